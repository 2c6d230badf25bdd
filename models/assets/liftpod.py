"""The LiftPod: the parametric model behind the meshes of its asset bundle.

A stand that folds: a base plate, two arms and a bar joined by hinges whose pins snap into forks, a
sleeve that slides along the bar, and a clamp, frame and slider, at its end. Run

    python -m snapfit.models.assets.liftpod

to write the meshes anew. Lengths are millimetres, as printed. Every body frame stands in the middle
of its part's box: arms and bar lie along x and turn about their z; the base's hinge turns about its
y, the frame's about its x.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from snapfit.models.assets.solids import (
    Solid,
    box,
    circle,
    cylinder,
    union,
    write_ply,
)
from snapfit.models.assets.solids_plates import (
    convex_outline,
    filleted,
    opening,
    plate,
    rectangle,
    stadium,
)
from snapfit.models.pose import Pose

DIRECTORY = Path(__file__).parent / "liftpod"

# How steep arms, bar and clamp frame stand in the assembled stand.
RISE_DEG: Mapping[str, float] = {"arm-first": 32, "arm-last": 148, "bar": 30, "clamp-frame": 90}
SLEEVE_AT_MM, SLIDER_AT_MM = 4.0, 24.0
# From where they are put on to where they stop; the clamp frame holds the sleeve on the bar.
SLEEVE_TRAVEL_MM, SLEEVE_HELD_MM = (-104.0, 12.0), (-4.0, 12.0)
SLIDER_TRAVEL_MM = (-39.4, 12.0)

_EYE, _PIN, _HOLE = 10.0, 3.0, 3.3
# A tongue fits between the tines of a fork; both reach from the hinge's axis to the shoulder.
_TONGUE, _SLOT, _SHOULDER = 1.6, 1.9, 20.4
_ARM_FIRST, _ARM_LAST, _ARM_WIDTH, _ARM_THICK = 115.0, 140.0, 20.0, 8.0
_BAR, _BAR_WIDTH, _BAR_THICK = 143.0, 15.0, 11.0
_BASE_X, _BASE_Y, _BASE_TOP, _PLATE = 124.0, 90.0, 13.0, 5.0
_BASE_AXIS_Z = _BASE_TOP - _EYE
_FRAME_X, _FRAME_Y, _FRAME_Z = 70.0, 80.0, 20.0
_FRAME_AXIS_Y = -_FRAME_Y / 2 + _EYE
_SILL = (-19.0, -11.0)
_RAIL_X, _LIP_X, _LIP_Z = 26.4, 23.4, (1.0, 5.0)
_SLIDER_X, _SLIDER_Y, _SLIDER_Z = 52.0, 46.0, (-4.6, 15.4)
_SLEEVE_Z, _GAP = 72.0, 0.3

# Where the hinge's axis stands in a part: at which it is held, and at which it holds the next.
HELD_AT_MM = {
    "arm-first": (-_ARM_FIRST / 2 + _EYE, 0.0, 0.0),
    "arm-last": (-_ARM_LAST / 2 + _EYE, 0.0, 0.0),
    "bar": (-(_BAR - _BAR_WIDTH) / 2, 0.0, 0.0),
    "clamp-frame": (0.0, _FRAME_AXIS_Y, 0.0),
}
HOLDS_AT_MM = {
    "base-plate": (0.0, 0.0, _BASE_AXIS_Z),
    **{name: (-x, 0.0, 0.0) for name, (x, _, _) in HELD_AT_MM.items() if name != "clamp-frame"},
}


def base_plate() -> Solid:
    """The foot: a plate with windows, gussets and a knuckle; a half turn maps it onto itself."""
    bottom, deck = -_BASE_TOP, -_BASE_TOP + _PLATE
    half_x, half_y = _BASE_X / 2, _BASE_Y / 2
    solid = plate(rectangle((-half_x, half_x), (-half_y, half_y), 16), (bottom, deck), 1.2)
    window = filleted([(18, 15, 4), (50, 15, 4), (42, 37, 6), (18, 37, 4)])
    cuts = union(
        [
            opening(window, (bottom, deck), 0.8),
            opening(circle(3, 24, (51, 33)), (bottom, deck), 0.8),
            opening(stadium((-9, 9), 27, 4.5), (bottom, deck), 0.8),
        ]
    )
    for mirror in ([1, 0, 0], [0, 1, 0]):
        cuts = cuts + cuts.mirror(mirror)
    return (solid - cuts) + _base_knuckle()


def _base_knuckle() -> Solid:
    """The tongue with its pins, a cheek and a long gusset on both of its sides."""
    floor = -_BASE_TOP + 1.5
    axis = (0.0, _BASE_AXIS_Z)
    foot = np.array([(-14.0, floor), (14.0, floor)])
    tongue = plate(convex_outline(circle(_EYE, 48, axis), foot), (-_TONGUE, _TONGUE), 0.3)
    cheek = plate(convex_outline(circle(8.5, 48, axis), foot), (4.5, 10), 0.8)
    ends = [(-55, floor), (55, floor), (55, floor + 5), (12, 6), (-12, 6), (-55, floor + 5)]
    gusset = plate(np.array(ends), (5.5, 9), 0.6)
    dimple = cylinder(4, (8.5, 11), 32).translate([*axis, 0])
    side = cheek + gusset - dimple
    return _about_y(tongue + side + side.mirror([0, 0, 1]) + _pins(axis))


def _about_y(solid: Solid) -> Solid:
    """From a plate in x and y to one that stands: its y becomes z, its z becomes -y."""
    return solid.rotate([90, 0, 0])


def _pins(at: tuple[float, float]) -> Solid:
    """The pins of a tongue, along z, with chamfered ends."""
    return plate(circle(_PIN, 32), (-_ARM_THICK / 2, _ARM_THICK / 2), 0.6).translate([*at, 0])


def arm_first() -> Solid:
    """The lower arm: a fork at both ends, a pocket in both faces; three half turns."""
    reach = _ARM_FIRST / 2 - _EYE - _SHOULDER - 4
    pocket = opening(stadium((-reach, reach), 0, 5.5), (_ARM_THICK / 2 - 1.8, _ARM_THICK / 2), 0.4)
    solid = _bar(_ARM_FIRST, _ARM_WIDTH, _ARM_THICK) - pocket - pocket.mirror([0, 0, 1])
    return _forked(solid, -HELD_AT_MM["arm-first"][0], _ARM_THICK)


def arm_last() -> Solid:
    """The upper arm: a tongue with pins at both ends, three windows; three half turns."""
    solid = _bar(_ARM_LAST, _ARM_WIDTH, _ARM_THICK)
    windows = [
        opening(stadium((x - 9, x + 9), 0, 4.5), (-_ARM_THICK / 2, _ARM_THICK / 2), 0.6)
        for x in (-23, 0, 23)
    ]
    eye = -HELD_AT_MM["arm-last"][0]
    room = union(
        [
            cylinder(_SHOULDER, span, 96).translate([x, 0, 0])
            for x in (-eye, eye)
            for span in ((_TONGUE, 9), (-9, -_TONGUE))
        ]
    )
    return solid - union(windows) - room + _pins((eye, 0)) + _pins((-eye, 0))


def bar() -> Solid:
    """The bar that carries sleeve and clamp: a fork at both ends; three half turns."""
    top = _BAR_THICK / 2
    groove = opening(stadium((-40, 40), 0, 3.5), (top - 1.5, top), 0.5)
    notches = [box((x - 0.5, x + 0.5), (5.0, 9.0), (-9, 9)) for x in range(-40, 41, 8)]
    notches += [notch.mirror([0, 1, 0]) for notch in notches]
    inner = plate(stadium((-60, 60), 0, 6.7), (-top, top), 0.5)
    solid = _bar(_BAR, _BAR_WIDTH, _BAR_THICK) - groove - groove.mirror([0, 0, 1])
    solid = solid - (union(notches) - inner)
    return _forked(solid, -HELD_AT_MM["bar"][0], _BAR_THICK)


def _bar(length: float, width: float, thick: float) -> Solid:
    outline = stadium((-length / 2, length / 2), 0, width / 2, 24)
    return plate(outline, (-thick / 2, thick / 2), 1.0)


def _forked(solid: Solid, eye: float, thick: float) -> Solid:
    """A slot and holes for a tongue and its pins at x = eye, and at the other end."""
    slot = cylinder(_SHOULDER, (-_SLOT, _SLOT), 96)
    hole = opening(circle(_HOLE, 32), (-thick / 2, thick / 2), 0.4)
    cuts = slot + hole
    return solid - cuts.translate([eye, 0, 0]) - cuts.translate([-eye, 0, 0])


def sleeve() -> Solid:
    """The sleeve: a square tube with a flat hole, rings and windows; three half turns."""
    half = _SLEEVE_Z / 2
    solid = plate(rectangle((-10, 10), (-10, 10), 3), (-half, half), 1.2)
    hole_x, hole_y = _BAR_WIDTH / 2 + _GAP, _BAR_THICK / 2 + _GAP
    hole = opening(rectangle((-hole_x, hole_x), (-hole_y, hole_y), 0.8), (-half, half), 0.6)
    inner = plate(rectangle((-9.2, 9.2), (-9.2, 9.2), 2.4), (-99, 99), 0.5)
    rings = [
        box((-20, 20), (-20, 20), (z - 0.8, z + 0.8)) - inner
        for side in (-1, 1)
        for z in (side * 23.0, side * 26.5, side * 30.0)
    ]
    window = plate(stadium((-15, 15), 0, 3.2), (-20, 20), 0.5).rotate([0, 90, 0])
    return solid - hole - union(rings) - window.rotate([0, 0, 90])


def clamp_frame() -> Solid:
    """The clamp's frame: sill, rails and back plate around the slider, a knuckle below."""
    back, front, half_x = -_FRAME_Z / 2, _FRAME_Z / 2, _FRAME_X / 2
    top = _FRAME_Y / 2
    sheet = [(half_x, _SILL[0], 5), (half_x, top, 7), (-half_x, top, 7), (-half_x, _SILL[0], 5)]
    solid = plate(filleted(sheet), (back, back + 5), 1.0)
    solid = solid + plate(rectangle((-half_x, half_x), _SILL, 3), (back, front), 1.0)
    hook = box(
        (-half_x + 4, half_x - 4), (_SILL[1] - 1, _SILL[1] + 1.6), (front - 3.5, front - 0.6)
    )
    rail = plate(rectangle((_LIP_X, half_x), (_SILL[0] + 3, top), 2), (back + 1, _LIP_Z[1]), 0.8)
    groove = box((0, _RAIL_X), (_SILL[1], top + 1), (back + 5, _LIP_Z[0]))
    mouth = box((0, _LIP_X), (_SILL[1], top + 1), (back + 5, 9))
    rail = rail - groove - mouth
    solid = solid + hook + rail + rail.mirror([1, 0, 0])
    back_span = (back, back + 5)
    windows = [
        opening(stadium((-17, 17), 28, 5.5), back_span, 0.8),
        opening(filleted([(-17, -4, 4), (17, -4, 4), (11, 16, 4), (-11, 16, 4)]), back_span, 0.8),
    ]
    rib = cylinder(1.2, (-30, 30), 16).rotate([0, 90, 0]).translate([0, _SILL[1] + 0.5, 0])
    ribs = [rib.translate([0, 0, z]) for z in (-1.5, 1.5, 4.5)]
    return solid - union([*windows, *ribs]) + _frame_knuckle()


def _frame_knuckle() -> Solid:
    """The tongue with its pins and a cheek on both of its sides, about x."""
    floor = _SILL[0] + 2
    axis = (0.0, _FRAME_AXIS_Y)
    tongue = convex_outline(circle(_EYE, 48, axis), np.array([(-_EYE, floor), (_EYE, floor)]))
    cheek = convex_outline(circle(7.5, 48, axis), np.array([(-9, floor), (9, floor)]))
    side = plate(cheek, (6.0, 10.5), 0.8)
    knuckle = plate(tongue, (-_TONGUE, _TONGUE), 0.3) + side + side.mirror([0, 0, 1])
    # The plates' z becomes x, their x becomes -z.
    return (knuckle + _pins(axis)).rotate([0, 90, 0])


def clamp_slider() -> Solid:
    """The clamp's slider: a tray between the rails, with a jaw at its upper end."""
    low, high = _SLIDER_Z
    half_x, half_y = _SLIDER_X / 2, _SLIDER_Y / 2
    tray = plate(rectangle((-half_x, half_x), (-half_y, half_y), 1.5), (low, _LIP_Z[0] - _GAP), 0.5)
    narrow = (-_LIP_X + _GAP + 0.2, _LIP_X - _GAP - 0.2)
    raised = plate(rectangle(narrow, (-half_y, half_y), 3), (low, 4.0), 0.8)
    neck = plate(rectangle(narrow, (half_y - 8, half_y), 1.5), (low, high - 1), 0.6)
    jaw = plate(rectangle((-half_x, half_x), (half_y - 8, half_y), 3), (_LIP_Z[1] + 0.5, high), 1.2)
    hook = box((-20, 20), (half_y - 9.6, half_y - 7), (high - 3.5, high - 0.8))
    pocket = opening(rectangle((-17, 17), (-half_y + 5, -3), 4), (1.5, 4.0), 0.6)
    window = opening(stadium((-13, 13), -half_y + 12, 4), (low, 1.5), 0.5)
    ribs = [box((-16, 16), (y - 0.7, y + 0.7), (3.2, 9)) for y in (1.5, 4.5, 7.5, 10.5)]
    groove = box((-21, 21), (half_y - 3, half_y + 9), (high - 7, high - 5.6))
    return union([tray, raised, neck, jaw, hook]) - union([pocket, window, *ribs, groove])


def assembled() -> dict[str, tuple[str, Pose]]:
    """Of each part but the base: its parent, and `parent_from_child`, metres."""
    # The frame's x is the bar's z; at no turn its y points along the bar.
    across = Pose.from_quaternion([-0.5, -0.5, -0.5, 0.5], [0, 0, 0])
    turns = {
        "arm-first": Pose.exp([math.pi / 2, 0, 0, 0, 0, 0]) @ _turn(RISE_DEG["arm-first"]),
        "arm-last": _turn(RISE_DEG["arm-last"] - RISE_DEG["arm-first"]),
        "bar": _turn(RISE_DEG["bar"] - RISE_DEG["arm-last"]),
        "clamp-frame": _turn(RISE_DEG["clamp-frame"] - RISE_DEG["bar"]) @ across,
    }
    parents = ("base-plate", "arm-first", "arm-last", "bar")
    poses = {}
    for parent, (name, turn) in zip(parents, turns.items(), strict=True):
        there = np.array(HOLDS_AT_MM[parent]) / 1000
        held = turn.rotation @ (np.array(HELD_AT_MM[name]) / 1000)
        poses[name] = (parent, Pose.from_rotation_translation(turn.rotation, there - held))
    along = Pose.from_quaternion([0.5, 0.5, 0.5, 0.5], [SLEEVE_AT_MM / 1000, 0, 0])
    in_rails = Pose.from_translation(0, SLIDER_AT_MM / 1000, sum(_SLIDER_Z) / 2000)
    return poses | {"sleeve": ("bar", along), "clamp-slider": ("clamp-frame", in_rails)}


def _turn(angle_deg: float) -> Pose:
    return Pose.exp([0, 0, math.radians(angle_deg), 0, 0, 0])


def parts() -> dict[str, Solid]:
    """The parts by name, millimetres, each in its body frame."""
    return {
        "arm-first": arm_first(),
        "arm-last": arm_last(),
        "bar": bar(),
        "base-plate": base_plate(),
        "clamp-frame": clamp_frame(),
        "clamp-slider": clamp_slider().translate([0, 0, -sum(_SLIDER_Z) / 2]),
        "sleeve": sleeve(),
    }


def main() -> None:
    """Writes the meshes of the bundle."""
    for name, solid in parts().items():
        write_ply(solid, DIRECTORY / f"{name}.ply")


if __name__ == "__main__":
    main()
