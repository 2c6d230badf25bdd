"""The Hobby Corner Clamp: the parametric model behind the meshes of its asset bundle.

A base with two fences at a right angle; a jaw with a matching nose that drops into the wide end of
a T-slot and slides under its lips; a bolt with a tri-lobe knob that goes through the threaded boss
of the base into the socket of the jaw. Run

    python -m snapfit.models.assets.hobby_corner_clamp

to write the meshes anew. Lengths are millimetres, as printed. The base is modelled with the bottom
of its plate at z = 0 and the slide along x. Every body frame stands in the middle of its part's
box, that of the bolt on its axis, z from the knob to the tip.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from snapfit.models.assets.solids import (
    Points,
    Solid,
    box,
    chamfered,
    circle,
    cylinder,
    hull,
    inset_polygon,
    prism,
    rounded_polygon,
    thread,
    union,
    write_ply,
)

DIRECTORY = Path(__file__).parent / "hobby-corner-clamp"

# How the parts stand in the assembled clamp; the manifest says the same in metres.
JAW_IN_BASE_MM = (8.5, 0.0, 2.9)
JAW_TRAVEL_MM = (-27.5, 13.0)
BOLT_IN_BASE_MM = (-74.7, 0.0, 7.0)
BOLT_ENGAGED_MM = 12.0
THREAD_LEAD_MM = 15.0

_BASE_WIDTH, _BASE_HEIGHT, _PLATE = 99.0, 54.0, 12.0
_AXIS_Z = _BASE_HEIGHT / 2 + BOLT_IN_BASE_MM[2]
_APEX_X = 68.0
_BOSS_X = (-80.0, -62.0)
_SLOT_X = (-54.4, 14.0)
_ENTRY_TO_X = -26.6
_GAP = 0.4

_JAW_LENGTH, _JAW_WIDTH, _JAW_HEIGHT = 85.0, 64.0, 53.0
_JAW_FLOOR = -_JAW_HEIGHT / 2 + 8.8
_TONGUE_X = (-34.5, -8.5)
_RIDGE_X = -8.0

_BOLT_LENGTH, _THREAD_LENGTH = 131.0, 48.2
_KNOB_TO_Z = -41.5
_STARTS, _THREAD_RADIUS, _ROOT_RADIUS, _PILOT_RADIUS = 3, 9.0, 6.8, 5.8
_LOBES, _LOBE_AT, _LOBE_RADIUS = 3, 25.86, 7.1


def base() -> Solid:
    """The base: plate, fences with ribs and a ruler, threaded boss, T-slot, holes."""
    envelope = prism(_plate_outline(), (0, _BASE_HEIGHT))
    solid = chamfered(_plate_outline(), (0, _PLATE), 1.2)
    solid = solid + ((_fence() + _fence().mirror([0, 1, 0]) + _boss()) ^ envelope)
    solid = solid - _slot() - _plate_holes() - _boss_hole()
    return solid.translate([0, 0, -_BASE_HEIGHT / 2])


def _plate_outline() -> Points:
    half = _BASE_WIDTH / 2
    upper = [(80.0, half - 14), (66.0, half), (-60.0, half), (-80.0, 34.0)]
    return np.array([*upper, *((x, -y) for x, y in reversed(upper))])


def _fence() -> Solid:
    """The fence on the left, y > 0: along u from the apex, its inner face at v = 0."""
    bar = chamfered(_rectangle((6, 90), (0, 9)), (1, 42), 1.2)
    profile = np.array([(0.0, 0.0), (16.0, 0.0), (16.0, 13.0), (0.0, 38.0)])
    rib = prism(profile, (-2.5, 2.5)).rotate([90, 0, 90])
    ribs = [rib.translate([u, 8.5, 0]) for u in (13.0, 42.0)]
    marks = [
        box((u - 0.5, u + 0.5), (-1, 0.8), (34 if i % 2 else 29, 45))
        for i, u in enumerate(range(12, 66, 6))
    ]
    fence = union([bar, *ribs]) - union(marks)
    # u runs along (-1, 1), v along (1, 1): a turn by 135 degrees, mirrored.
    return fence.mirror([0, 1, 0]).rotate([0, 0, 135]).translate([_APEX_X, 0, 0])


def _boss() -> Solid:
    """An arch around the bolt's axis, and a rib on both of its sides."""
    arch = np.concatenate([circle(20.0, 40, (0, _AXIS_Z)), [(-23.0, 1.0), (23.0, 1.0)]])
    outline = arch[_convex_order(arch)]
    # The prism's axis z becomes the base's x, its x the base's y.
    solid = chamfered(outline, _BOSS_X, 1.2)
    rib = np.array([(-44.0, 8.0), (44.0, 8.0), (19.0, 40.0), (-19.0, 40.0)])
    solid = solid + prism(rib, (-74.0, -68.0))
    return solid.rotate([90, 0, 90])


def _convex_order(points: Points) -> list[int]:
    """Indices of the convex hull of points (N, 2), counter-clockwise."""
    order = sorted(range(len(points)), key=lambda i: (points[i][0], points[i][1]))
    chain: list[int] = []
    for half in (order, order[::-1]):
        start = len(chain)
        for i in half:
            while len(chain) > start + 1 and _turn(points, chain[-2], chain[-1], i) <= 1e-9:
                chain.pop()
            chain.append(i)
        chain.pop()
    return chain


def _turn(points: Points, a: int, b: int, c: int) -> float:
    (ax, ay), (bx, by), (cx, cy) = points[a], points[b], points[c]
    return float((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))


def _slot() -> Solid:
    """The T-slot, open to the top at its wide entry, so that the tongue can be dropped in."""
    neck = box(_SLOT_X, (-8, 8), (6, _PLATE + 1))
    cavity = box(_SLOT_X, (-14.2, 14.2), (3, 7.6))
    entry = box((_SLOT_X[0], _ENTRY_TO_X), (-14.2, 14.2), (3, _PLATE + 1))
    return union([neck, cavity, entry])


def _plate_holes() -> Solid:
    """Screw holes with countersinks, windows that save plastic, a relief hole at the apex."""
    screw = cylinder(2.6, (-1, _PLATE + 1), 24) + cylinder(2.6, (8.4, 12.01), 24, 5.6)
    window = chamfered(_rectangle((-52, -12), (24, 38)), (-5, 30), 4)
    small = chamfered(_rectangle((-4, 18), (24, 38)), (-5, 30), 4)
    holes = [screw.translate([64, 36.5, 0]), screw.translate([-67, 30, 0]), window, small]
    relief = cylinder(5, (-1, 60), 32).translate([_APEX_X - 1, 0, 0])
    return union([*holes, *(hole.mirror([0, 1, 0]) for hole in holes), relief])


def _boss_hole() -> Solid:
    """The bolt's thread in its assembled place, wider by the gap, and chamfers at both mouths."""
    cutter = thread(_ROOT_RADIUS + _GAP, _THREAD_RADIUS + _GAP, THREAD_LEAD_MM, _STARTS, (-10, 20))
    mouth = cylinder(_THREAD_RADIUS + 1.4, (-0.01, 2), 48, _ROOT_RADIUS)
    along_x = [0, 90, 0]
    return union(
        [
            _bolt_to_base(cutter),
            mouth.rotate(along_x).translate([_BOSS_X[0], 0, _AXIS_Z]),
            mouth.mirror([0, 0, 1]).rotate(along_x).translate([_BOSS_X[1], 0, _AXIS_Z]),
        ]
    )


def _bolt_to_base(solid: Solid) -> Solid:
    """From the bolt's frame to that of the base's plate: z, x, y become x, y, z."""
    x, y, z = BOLT_IN_BASE_MM
    return solid.rotate([90, 0, 90]).translate([x, y, z + _BASE_HEIGHT / 2])


def jaw() -> Solid:
    """The jaw: wedge with a right-angled nose, tapered on its right side, tongue, socket."""
    solid = _jaw_body() + _tongue() - _socket() - _jaw_recesses()
    return solid - _nose_grooves()


def _jaw_body() -> Solid:
    half, tail = _JAW_WIDTH / 2, -_JAW_LENGTH / 2
    corner = 3.0
    # The arc at the nose takes away corner * (sqrt(2) - 1) of its length.
    nose = _JAW_LENGTH / 2 + corner * (math.sqrt(2) - 1)
    shoulder = nose - half
    sharp = np.array(
        [
            *[(nose, 0), (shoulder, half), (_RIDGE_X, half), (tail, half)],
            *[(tail, -17.0), (-22.0, -half), (_RIDGE_X, -half), (shoulder, -half)],
        ]
    )
    outline = rounded_polygon(sharp, corner, 10)
    edge = 2.0
    lower, upper = [], []
    for angle in np.linspace(0, math.pi / 2, 7):
        ring = inset_polygon(outline, edge * (1 - math.sin(angle)))
        drop = edge * (1 - math.cos(angle))
        lower.append((ring, np.full(len(ring), _JAW_FLOOR + drop)))
        upper.append((ring, _roof(ring) - drop))
    return hull(*lower, *upper)


def _roof(ring: Points) -> Points:
    """Height of the roof over points (N, 2): level, then falling from the ridge to the nose."""
    slope = 0.3
    height: Points = _JAW_HEIGHT / 2 - slope * np.maximum(ring[:, 0] - _RIDGE_X, 0)
    return height


def _tongue() -> Solid:
    """A neck and a flange, both a gap narrower than the slot."""
    bottom = -_JAW_HEIGHT / 2
    neck = box(_TONGUE_X, (-8 + _GAP, 8 - _GAP), (bottom + 1, _JAW_FLOOR + 1))
    width = (-14.2 + _GAP, 14.2 - _GAP)
    return neck + chamfered(_rectangle(_TONGUE_X, width), (bottom, bottom + 3.8), 0.6)


def _socket() -> Solid:
    """The hole that takes the bolt's pilot, with a chamfered mouth."""
    axis_z = BOLT_IN_BASE_MM[2] - JAW_IN_BASE_MM[2]
    hole = cylinder(6.5, (-1, 25), 96) + cylinder(8.5, (-0.01, 2), 96, 6.5)
    return hole.rotate([0, 90, 0]).translate([-_JAW_LENGTH / 2, 0, axis_z])


def _jaw_recesses() -> Solid:
    """A pocket in the left side, finger grooves in the right one, a pocket in the roof."""
    pocket = prism(_rectangle((-34, 2), (-10, 18)), (26, 40)).rotate([90, 0, 180])
    pocket = pocket.translate([-32, 0, 0])
    rib = box((-19, -15), (20, 40), (-10, 18))
    grooves = [
        cylinder(3.2, (-8, 40), 64).translate([x, -_JAW_WIDTH / 2 - 0.8, 0])
        for x in (-16.0, -8.0, 0.0)
    ]
    roof = chamfered(_rectangle((-33, -12), (-10, 14)), (_JAW_HEIGHT / 2 - 7, 60), 2)
    return union([pocket - rib, *grooves, roof])


def _nose_grooves() -> Solid:
    """Shallow grooves across both faces of the nose, for grip."""
    grooves = []
    for side in (1, -1):
        for z in (-9.0, -2.0, 5.0):
            groove = box((-60, 60), (-0.9, 1), (z - 0.7, z + 0.7)).rotate([0, 0, -45 * side])
            middle = (_JAW_LENGTH / 2 - 16, 16 * side)
            reach = 0.5 / math.sqrt(2)
            grooves.append(groove.translate([middle[0] + reach, middle[1] + reach * side, 0]))
    return union(grooves)


def bolt() -> Solid:
    """The bolt: tri-lobe knob, three-start thread, plain pilot with a groove near its tip."""
    return _knob() + _shaft()


def _knob() -> Solid:
    start = -_BOLT_LENGTH / 2
    arms, dimples = [], []
    for i in range(_LOBES):
        angle_deg = 90 + 360 / _LOBES * i
        outline = np.concatenate([circle(13.0, 36), circle(_LOBE_RADIUS, 24, (_LOBE_AT, 0.0))])
        arm = chamfered(outline[_convex_order(outline)], (start + 3, _KNOB_TO_Z - 4), 2.0)
        arms.append(arm.rotate([0, 0, angle_deg]))
        dimple = cylinder(3.4, (start, 0), 24).translate([_LOBE_AT, 0, 0])
        dimples.append(dimple.rotate([0, 0, angle_deg]))
    cap = chamfered(circle(12.0, 36), (start, start + 10), 1.5)
    collar = chamfered(circle(12.5, 36), (_KNOB_TO_Z - 10, _KNOB_TO_Z), 1.0)
    star = union([*arms, cap, collar])
    hexagon = prism(circle(6.0, 6), (start - 1, start + 3))
    return star - union(dimples) - hexagon


def _shaft() -> Solid:
    thread_to = _KNOB_TO_Z + _THREAD_LENGTH
    tip = _BOLT_LENGTH / 2
    ridge = thread(
        _ROOT_RADIUS, _THREAD_RADIUS, THREAD_LEAD_MM, _STARTS, (_KNOB_TO_Z - 2, thread_to)
    )
    lead_in = cylinder(_THREAD_RADIUS + 0.1, (_KNOB_TO_Z - 3, thread_to - 2.5), 48) + cylinder(
        _THREAD_RADIUS + 0.1, (thread_to - 2.5, thread_to), 48, _ROOT_RADIUS - 0.3
    )
    pilot = cylinder(_PILOT_RADIUS, (thread_to - 4, tip - 2.5), 42)
    point = cylinder(_PILOT_RADIUS, (tip - 2.5, tip), 42, _PILOT_RADIUS - 2.5)
    ring = cylinder(9, (tip - 11, tip - 8.5), 42) - cylinder(4.9, (tip - 12, tip - 7), 42)
    return (ridge ^ lead_in) + pilot + point - ring


def _rectangle(x: tuple[float, float], y: tuple[float, float]) -> Points:
    return np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])], dtype=np.float64)


def parts() -> dict[str, Solid]:
    """The parts by name, millimetres, each in its body frame."""
    return {"base": base(), "jaw": jaw(), "bolt": bolt()}


def main() -> None:
    """Writes the meshes of the bundle."""
    for name, solid in parts().items():
        write_ply(solid, DIRECTORY / f"{name}.ply")


if __name__ == "__main__":
    main()
