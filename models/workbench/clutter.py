"""What else lies on the bench: tools and boxes that never move. Built in millimetres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.assets.solids import (
    Solid,
    box,
    chamfered,
    circle,
    cylinder,
    rounded_polygon,
    union,
)
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose


@dataclass(frozen=True, eq=False)
class Item:
    """A static thing, or a part of one that has its own colour.

    Attributes:
        mesh: metres, its own frame, standing on z = 0.
        world_from_body: where it stands.
        color_rgb: sRGB, 0 to 255.
        gloss: strength of the highlight.
    """

    mesh: Mesh
    world_from_body: Pose
    color_rgb: tuple[int, int, int]
    gloss: float


def clutter() -> tuple[Item, ...]:
    """The things around the working place."""
    items: list[Item] = []
    for solids, x_m, y_m, yaw_deg in (
        (_mug(), -0.36, 0.27, 35.0),
        (_bin(), 0.42, 0.30, -14.0),
        (_tape(), 0.20, 0.31, 0.0),
        (_screwdriver(), -0.40, -0.02, 74.0),
        (_tape_measure(), -0.14, 0.33, 24.0),
        (_ruler(), 0.43, -0.02, 97.0),
        (_pencil(), 0.33, 0.12, 38.0),
        (_offcut(), -0.60, 0.14, 12.0),
    ):
        pose = Pose.exp([0, 0, np.radians(yaw_deg), 0, 0, 0])
        pose = Pose.from_rotation_translation(pose.rotation, (x_m, y_m, 0.0))
        items += [Item(_mesh(solid), pose, color, gloss) for solid, color, gloss in solids]
    return tuple(items)


def scattered(rng: np.random.Generator) -> tuple[Item, ...]:
    """Some of the things, and others, around a working place that stays free; none on another."""
    makers = [_MAKERS[i] for i in rng.permutation(len(_MAKERS))[: int(rng.integers(7, 10))]]
    # The large ones find a place first.
    makers.sort(key=lambda maker: -maker[1])
    taken = np.zeros((_CELLS, _CELLS), dtype=np.uint8)
    cv2.fillConvexPoly(taken, _cells(_WORKING_PLACE), 1)
    items: list[Item] = []
    for make, _, tall, painted in makers:
        solids = make()
        if painted and rng.random() < 0.6:
            first, _, gloss = solids[0]
            solids[0] = (first, _PAINTS[int(rng.integers(len(_PAINTS)))], gloss)
        meshes = [_mesh(solid) for solid, _, _ in solids]
        points = np.vstack([mesh.vertices for mesh in meshes])
        low_y = 0.24 if tall else -0.16
        for _ in range(200):
            x, y = rng.uniform(-0.56, 0.56), rng.uniform(low_y, 0.40)
            turn = Pose.exp([0, 0, rng.uniform(0, 2 * np.pi), 0, 0, 0])
            pose = Pose.from_rotation_translation(turn.rotation, (x, y, 0.0))
            own = np.zeros_like(taken)
            hull = cv2.convexHull(_cells(pose.transform(points)))
            cv2.fillConvexPoly(own, hull, 1)
            own = cv2.dilate(own, np.ones((5, 5), dtype=np.uint8))
            if not (own & taken).any():
                taken |= own
                for mesh, (_, color, gloss) in zip(meshes, solids, strict=True):
                    items.append(Item(mesh, pose, color, gloss))
                break
    return tuple(items)


def _cells(points_m: Array) -> npt.NDArray[np.int32]:
    """(N, 2) cells of a grid over the bench in which points (N, 2 or 3) stand."""
    return np.round((points_m[:, :2] + _HALF_M) / (2 * _HALF_M) * _CELLS).astype(np.int32)


Painted = tuple[Solid, tuple[int, int, int], float]


def _mesh(solid: Solid) -> Mesh:
    mesh = solid.to_mesh()
    vertices = np.asarray(mesh.vert_properties)[:, :3] * 0.001
    return Mesh(vertices.astype(np.float32), np.asarray(mesh.tri_verts).astype(np.int32))


def _mug() -> list[Painted]:
    wall = cylinder(41, (2, 96), 96) + cylinder(39, (0, 2), 96, 41) - cylinder(37.5, (5, 99), 96)
    ring = cylinder(31, (-6, 6), 64) - cylinder(22, (-8, 8), 64)
    handle = (ring ^ box((0, 60), (-60, 60), (-20, 20))).rotate([90, 0, 0]).translate([38, 0, 50])
    coffee = cylinder(37.4, (5, 70), 96)
    glaze = (70, 104, 112)
    return [(wall + (handle - cylinder(40, (0, 96), 96)), glaze, 0.35), (coffee, (46, 28, 18), 0.6)]


def _bin() -> list[Painted]:
    """An open sorting bin with screws in one of its compartments."""
    outline = np.array([(-80.0, -55), (80, -55), (80, 55), (-80, 55)])
    shell = chamfered(outline, (0, 48), 3)
    inner = chamfered(outline * (77 / 80, 52 / 55), (3, 80), 3)
    walls = box((-1.2, 1.2), (-54, 54), (2, 42)) + box((-79, 0), (-1.2, 1.2), (2, 42))
    rng = np.random.default_rng(5)
    screws = []
    for _ in range(26):
        screw = cylinder(1.9, (0, 20), 10) + cylinder(4.2, (-2.6, 0), 12)
        tilt, yaw = rng.uniform(70, 110), rng.uniform(0, 360)
        place = [rng.uniform(18, 62), rng.uniform(-38, 38), rng.uniform(5, 12)]
        screws.append(screw.rotate([0, tilt, yaw]).translate(place))
    return [(shell - inner + walls, (118, 124, 120), 0.12), (union(screws), (150, 150, 146), 0.6)]


def _tape() -> list[Painted]:
    roll = cylinder(47, (0, 25), 96) - cylinder(39.5, (-1, 30), 96)
    core = cylinder(39.5, (0.4, 24.6), 96) - cylinder(37.5, (-1, 30), 96)
    return [(roll, (206, 186, 132), 0.05), (core, (150, 122, 92), 0.02)]


def _screwdriver() -> list[Painted]:
    handle = cylinder(14, (-100, -12), 12, 15) + cylinder(15, (-12, 0), 12, 8)
    grooves = [
        cylinder(4, (-88, -18), 16).translate([16.5, 0, 0]).rotate([0, 0, 60 * i]) for i in range(6)
    ]
    shaft = cylinder(3, (0, 105), 24) + box((-4, 4), (-0.6, 0.6), (100, 118))
    lying = [90, 0, 0]
    red = (handle - union(grooves)).rotate(lying).translate([0, 0, 14.6])
    cap = cylinder(12.5, (-106, -99), 24).rotate(lying).translate([0, 0, 14.6])
    steel = shaft.rotate(lying).translate([0, 0, 14.6])
    return [(red, (168, 34, 30), 0.25), (cap, (28, 28, 30), 0.2), (steel, (168, 170, 172), 0.9)]


def _tape_measure() -> list[Painted]:
    """Orange and black: the colours of a part, so that colour alone does not tell the parts."""
    case = chamfered(circle(34, 8), (0, 38), 5)
    grip = chamfered(circle(36, 8), (9, 29), 2) ^ box((-40, 40), (-40, 6), (0, 40))
    return [(case, (34, 34, 36), 0.2), (grip, (216, 118, 40), 0.15)]


def _ruler() -> list[Painted]:
    plate = box((-155, 155), (-15, 15), (0, 1.0))
    marks = [
        box((x - 0.35, x + 0.35), (6 if x % 10 else 2, 14.6), (0.9, 1.15))
        for x in range(-150, 151, 5)
    ]
    return [(plate, (172, 174, 176), 0.5), (union(marks), (40, 40, 42), 0.0)]


def _pencil() -> list[Painted]:
    wood = cylinder(3.8, (0, 150), 6)
    tip = cylinder(3.8, (150, 166), 24, 1.0)
    lead = cylinder(1.0, (166, 170), 12, 0.3)
    lying = [0, 90, 0]
    colors = ((206, 168, 40), (196, 160, 118), (40, 40, 42))
    return [
        (solid.rotate(lying).translate([0, 0, 3.4]), color, 0.1)
        for solid, color in zip((wood, tip, lead), colors, strict=True)
    ]


def _offcut() -> list[Painted]:
    outline = np.array([(-60.0, -22), (60, -22), (44, 22), (-60, 22)])
    return [(chamfered(outline, (0, 28), 0.6), (188, 152, 104), 0.02)]


def _bottle() -> list[Painted]:
    """Of wood glue: a round body, a shoulder and a spout with a cap."""
    body = cylinder(28, (0, 105), 64) + cylinder(28, (105, 122), 64, 12)
    label = cylinder(28.3, (28, 84), 64) - cylinder(27.5, (20, 90), 64)
    cap = cylinder(11, (122, 132), 32) + cylinder(9, (132, 158), 32, 3)
    return [(body, (196, 190, 176), 0.3), (label, (172, 120, 30), 0.2), (cap, (150, 34, 28), 0.3)]


def _hex_key() -> list[Painted]:
    long = cylinder(2.9, (0, 92), 6).rotate([0, 90, 0])
    short = cylinder(2.9, (0, 34), 6).rotate([-90, 0, 0])
    return [((long + short).translate([0, 0, 2.6]), (64, 64, 68), 0.7)]


def _carton() -> list[Painted]:
    """Closed, with a strip of tape across."""
    case = chamfered(np.array([(-62.0, -44), (62, -44), (62, 44), (-62, 44)]), (0, 62), 0.8)
    strip = box((-62.3, 62.3), (-13, 13), (30, 62.4))
    return [(case, (168, 132, 92), 0.03), (strip, (196, 174, 128), 0.3)]


def _spool() -> list[Painted]:
    """Filament, lying."""
    rims = cylinder(68, (0, 4), 96) + cylinder(68, (42, 46), 96) - cylinder(20, (-1, 50), 64)
    core = cylinder(27, (1, 45), 64) - cylinder(20, (-1, 50), 64)
    wound = cylinder(56, (4, 42), 96) - cylinder(27, (0, 50), 64)
    return [(wound, (58, 96, 150), 0.25), (rims + core, (40, 40, 42), 0.2)]


def _sponge() -> list[Painted]:
    outline = rounded_polygon(np.array([(-52.0, -34), (52, -34), (52, 34), (-52, 34)]), 5, 4)
    pad = chamfered(outline, (0, 30), 1)
    return [(pad, (196, 170, 70), 0.0), (chamfered(outline, (30, 36), 1), (60, 92, 66), 0.0)]


# How to make each thing, about how far it reaches (m), whether it is tall, and comes in colours.
_MAKERS: tuple[tuple[Callable[[], list[Painted]], float, bool, bool], ...] = (
    (_mug, 0.07, True, True),
    (_bin, 0.10, True, True),
    (_tape, 0.05, False, True),
    (_screwdriver, 0.11, False, True),
    (_tape_measure, 0.04, False, False),
    (_ruler, 0.155, False, False),
    (_pencil, 0.17, False, True),
    (_offcut, 0.06, False, False),
    (_bottle, 0.03, True, False),
    (_hex_key, 0.09, False, False),
    (_carton, 0.08, True, False),
    (_spool, 0.07, True, True),
    (_sponge, 0.06, False, False),
)
_PAINTS = (
    (70, 104, 112),
    (150, 60, 48),
    (60, 74, 108),
    (196, 188, 172),
    (92, 110, 78),
    (186, 140, 52),
    (52, 52, 56),
)
_HALF_M, _CELLS = 0.8, 320
_WORKING_PLACE = np.array(
    [(-0.30, -0.30), (0.30, -0.30), (0.34, 0.05), (0.22, 0.22), (-0.22, 0.22), (-0.34, 0.05)]
)
