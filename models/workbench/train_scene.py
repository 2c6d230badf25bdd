"""One training image before it is drawn: which parts lie where, what else is there, who looks.

World frame: the bench's top is z = 0. Everything comes from the generator that is passed in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.hand import Body, Person, hand_bodies
from snapfit.models.workbench.scene import Lamp, looking_at
from snapfit.models.workbench.train_colors import jittered, painted, plastic
from snapfit.models.workbench.train_kernels import Sheets
from snapfit.models.workbench.train_modules import Module, Modules, Space, afloat, resting
from snapfit.models.workbench.train_room import sampled_lamps, sampled_room
from snapfit.models.workbench.train_stock import Stock

Rng = np.random.Generator

# Half as many pixels again as the network looks at (640 wide), of the camera of the test split.
STANDARD_CAMERA = PinholeCamera(960, 540, fx=455.4, fy=455.4, cx=479.4, cy=273.6)

_FOCAL_SPREAD, _CENTER_SPREAD_PX = 0.15, 12.0
_NEAREST_M = 0.10
_TRIES = 24
_HAND_SHARE, _BEFORE_SHARE = 0.3, 0.2
_LENS_M = 0.05


@dataclass(frozen=True, eq=False)
class TrainScene:
    """What there is to be drawn.

    Attributes:
        camera: that looks.
        camera_from_world: from where.
        parts: of the asset, each with what is drawn of it.
        others: foreign things.
        hand: bones and flesh, perhaps none.
        sheets: bench, floor, wall and flat things.
        lamps: what throws shadows.
        ambient: (2, 3) light from above and below.
        state: the assembly state that joined parts are in, None if all are apart.
    """

    camera: PinholeCamera
    camera_from_world: Pose
    parts: tuple[tuple[Part, Body], ...]
    others: tuple[Body, ...]
    hand: tuple[Body, ...]
    sheets: Sheets
    lamps: tuple[Lamp, ...]
    ambient: Array
    state: str | None


@dataclass(frozen=True, eq=False)
class _Placed:
    module: Module
    pose: Pose

    @property
    def points(self) -> Array:
        return self.pose.transform(self.module.points)


def sampled_scene(
    asset: Asset, modules: Modules, stock: Stock, assembled: bool, rng: Rng, scale: float = 1.0
) -> TrainScene:
    """A scene with parts joined as some state of the assembly graph has them, or all apart."""
    wanted, state = modules.sampled(assembled, rng)
    space = Space(gap=rng.random() < 0.6)
    crowd_m, in_air = rng.uniform(0.04, 0.26), rng.choice((0.1, 0.5))
    placed = [p for m in wanted if (p := _placed(m, space, crowd_m, in_air, rng)) is not None]
    camera, view = _sampled_camera(placed, rng, scale)
    placed = [each for each in placed if _in_front(each.points, view)]
    colors = painted(asset.parts, rng)
    gloss = rng.uniform(0.02, 0.45)
    parts = tuple(
        (part, Body(part.mesh, each.pose @ pose, jittered(colors[part.name], rng), gloss))
        for each in placed
        for part, pose in each.module.parts
    )
    others = _foreign(stock, space, list(colors.values()), rng)
    if placed and rng.random() < _BEFORE_SHARE:
        others += _before(placed, stock, view, rng)
    others = [body for body in others if _in_front(_box_of(body), view)]
    hand = _sampled_hand(placed, view, rng) if placed and rng.random() < _HAND_SHARE else []
    lamps, ambient = sampled_lamps(rng)
    sheets = sampled_room(stock, camera, view, rng)
    return TrainScene(
        camera, view, parts, tuple(others), tuple(hand), sheets, lamps, ambient, state
    )


def _placed(
    module: Module, space: Space, crowd_m: float, in_air: float, rng: Rng
) -> _Placed | None:
    """Lying on the bench or held above it, where nothing else is; None if there is no room."""
    held = rng.random() < in_air
    for i in range(_TRIES):
        pose = afloat(module, rng) if held else resting(module, rng)
        reach = crowd_m * (1 + 2 * i / _TRIES)
        x, y = rng.normal(0, reach, 2)
        low = float(pose.transform(module.points)[:, 2].min())
        z = rng.uniform(0.004, 0.2) - low if held else 0.0
        found = _Placed(module, Pose.from_translation(x, y, z) @ pose)
        if space.take(found.points):
            return found
    return None


def _sampled_camera(
    placed: Sequence[_Placed], rng: Rng, scale: float
) -> tuple[PinholeCamera, Pose]:
    """From 0.3 to 1.0 m away, from grazing to straight down, turned to either side."""
    base = STANDARD_CAMERA
    factor = math.exp(rng.uniform(-1, 1) * math.log(1 + _FOCAL_SPREAD))
    shift = rng.uniform(-_CENTER_SPREAD_PX, _CENTER_SPREAD_PX, 2)
    camera = PinholeCamera(
        base.width,
        base.height,
        base.fx * factor,
        base.fy * factor * rng.uniform(0.995, 1.005),
        base.cx + shift[0],
        base.cy + shift[1],
    )
    camera = camera if scale == 1.0 else camera.scaled(scale)
    middles = np.array([each.points.mean(axis=0) for each in placed] or [np.zeros(3)])
    target = rng.dirichlet(np.ones(len(middles))) @ middles + rng.normal(0, 0.035, 3)
    distance = 0.3 + 0.7 * rng.beta(1.2, 2.4)
    height = math.radians(8 + 82 * rng.beta(1.7, 1.5))
    around = rng.uniform(0, 2 * math.pi)
    away = np.array(
        [
            math.cos(height) * math.cos(around),
            math.cos(height) * math.sin(around),
            math.sin(height),
        ]
    )
    eye = target + distance * away
    eye[2] = max(eye[2], 0.04)
    view = looking_at((eye[0], eye[1], eye[2]), (target[0], target[1], target[2]))
    spread = 60.0 if rng.random() < 0.1 else 9.0
    roll = Pose.exp([0, 0, math.radians(rng.normal(0, spread)), 0, 0, 0])
    return camera, roll @ view


def _foreign(
    stock: Stock, space: Space, part_colors: Sequence[tuple[int, int, int]], rng: Rng
) -> list[Body]:
    """Foreign things among the parts, now and then one above them; many are of their colours."""
    n = int(rng.integers(1, 19)) if rng.random() < 0.85 else 0
    alike, crowd_m = rng.random() < 0.4, rng.uniform(0.08, 0.24)
    bodies = []
    for _ in range(n):
        thing = stock.things[int(rng.integers(len(stock.things)))]
        found = _placed(thing.scaled(rng.uniform(0.6, 1.5)), space, crowd_m, 0.15, rng)
        if found is not None:
            color = part_colors[int(rng.integers(len(part_colors)))] if alike else plastic(rng)
            bodies.append(_painted(found, color, rng))
    return bodies


def _before(placed: Sequence[_Placed], stock: Stock, view: Pose, rng: Rng) -> list[Body]:
    """Something that hangs between the camera and a module."""
    goal = placed[int(rng.integers(len(placed)))].points.mean(axis=0)
    eye = view.inverse().translation
    place = goal + rng.uniform(0.15, 0.6) * (eye - goal) + rng.normal(0, 0.02, 3)
    module = stock.things[int(rng.integers(len(stock.things)))].scaled(rng.uniform(0.5, 1.2))
    pose = Pose.from_translation(*place) @ afloat(module, rng)
    return [_painted(_Placed(module, pose), plastic(rng), rng)]


def _painted(found: _Placed, color: tuple[int, int, int], rng: Rng) -> Body:
    """A thing, which is one part, as it is drawn."""
    ((part, _),) = found.module.parts
    return Body(part.mesh, found.pose, jittered(color, rng), rng.uniform(0, 0.6))


def _sampled_hand(placed: Sequence[_Placed], view: Pose, rng: Rng) -> list[Body]:
    """A hand at one of the modules: it comes from where somebody may stand."""
    goal = placed[int(rng.integers(len(placed)))]
    middle = goal.points.mean(axis=0)
    to_eye = view.inverse().translation - middle
    around = math.atan2(to_eye[1], to_eye[0]) + rng.normal(0, 0.9)
    shoulder = np.array([math.cos(around), math.sin(around), 0.0]) * 0.55
    shoulder = shoulder + middle + (0.0, 0.0, rng.uniform(0.05, 0.35))
    reach = middle - shoulder
    fingers = reach / np.linalg.norm(reach) + rng.normal(0, 0.25, 3)
    back = np.array([0.0, 0.0, 0.7]) + 0.6 * to_eye / np.linalg.norm(to_eye)
    back = back + rng.normal(0, 0.35, 3)
    x = fingers / np.linalg.norm(fingers)
    z = back - (back @ x) * x
    z = z / np.linalg.norm(z)
    rotation = np.column_stack([x, np.cross(z, x), z])
    gap = float(np.quantile((goal.points - middle) @ z, 0.8))
    palm = middle + z * (gap + rng.uniform(0.008, 0.035)) - x * rng.uniform(0.02, 0.09)
    palm[2] = max(palm[2], 0.03)
    skin = Person.sampled(rng)
    glove = plastic(rng)
    person = Person(glove, skin.sleeve_rgb) if rng.random() < 0.12 else skin
    person = Person(jittered(person.skin_rgb, rng), jittered(plastic(rng), rng))
    pose = Pose.from_rotation_translation(rotation, palm)
    bodies = hand_bodies(pose, rng.uniform(0.1, 0.75), person, shoulder)
    return [] if any(_covers_lens(body, view) for body in bodies) else bodies


def _covers_lens(body: Body, view: Pose) -> bool:
    points = view.transform(body.world_from_body.transform(body.mesh.vertices))
    return bool((np.linalg.norm(points, axis=1) < _LENS_M).any())


def _in_front(points: Array, view: Pose) -> bool:
    return bool((view.transform(points)[:, 2] > _NEAREST_M).all())


def _box_of(body: Body) -> Array:
    low, high = body.mesh.vertices.min(axis=0), body.mesh.vertices.max(axis=0)
    unit = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return body.world_from_body.transform(low + unit * (high - low))
