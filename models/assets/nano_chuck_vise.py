"""The vise of the Nano Chuck: its base with the fixed jaw, the slider, and the screw between them.

Millimetres. The vise's base is modelled standing on z = 0, the slide along y towards the fixed jaw,
the axis of the ball joint's stud along z.
"""

from __future__ import annotations

import numpy as np

from snapfit.models.assets.solids import Solid, box, circle, cylinder, union
from snapfit.models.assets.turned import (
    capped,
    convex,
    fluted_grip,
    rectangle,
    revolved,
    rounded_disc,
    rounded_prism,
    rounded_rectangle,
    screw_shaft,
    tapped_hole,
)

# How the parts stand in the assembled vise; the manifest says the same in metres.
SLIDER_IN_VISE_MM = (0.0, 0.0, 15.0)
SLIDER_TRAVEL_MM = (-27.0, 22.5)
SCREW_IN_VISE_MM = (0.0, -53.0, 20.5)
STUD_LEAD_MM, VISE_SCREW_LEAD_MM = 12.0, 12.0
# Root and crest radius, lead, starts.
STUD_THREAD = (5.9, 7.0, STUD_LEAD_MM, 2)
_SCREW_THREAD = (4.6, 5.5, VISE_SCREW_LEAD_MM, 3)
_GAP = 0.4

_HEIGHT, _WIDTH, _HALF_LENGTH = 77.0, 80.0, 54.0
_BED_X, _BED_Z = (-28.0, 28.0), (22.0, 38.0)
_JAW_Y = 36.0
_END_Y = (-54.0, -41.0)
_AXIS_Z = SCREW_IN_VISE_MM[2] + _HEIGHT / 2
# The collar of the ball joint ends this much below the vise; the stud starts there.
_STUD_TO_VISE_Z = 41.0 - 28.5
_VISE_ON_BALL_Z = 51.4

_SLIDER_HEIGHT, _SLIDER_LENGTH = 47.0, 26.0
_TONGUE_LENGTH, _TONGUE_TOP = 22.0, 8.4


def vise_base() -> Solid:
    """Bed with a T-slot on a socket for the stud, fixed jaw, end plate with the screw's thread."""
    bed = rounded_prism(rounded_rectangle(_BED_X, (-_HALF_LENGTH, _HALF_LENGTH), 5), _BED_Z, 2.0)
    foot = revolved([(0, 0), (15.0, 0), (17.0, 2), (17.0, 11), (27.0, 24), (0, 24)], 64)
    solid = union([bed, foot, _fixed_jaw(), _end_plate()])
    solid = solid - _slot() - _stud_hole() - _end_hole() - _marks()
    return solid.translate([0, 0, -_HEIGHT / 2])


def _fixed_jaw() -> Solid:
    """The jaw across the bed's end: round shoulders, two ribs behind, crossed grooves in front."""
    top = [(28.0, _HEIGHT), (-28.0, _HEIGHT)]
    outline = np.array([(-40, 30), (40, 30), (40, 66), *top, (-40, 66)], dtype=np.float64)
    # The prism's axis z becomes -y.
    plate = rounded_prism(convex(outline), (-_HALF_LENGTH, -_JAW_Y), 2.0).rotate([90, 0, 0])
    recess = rounded_prism(rectangle((-14, 14), (44, 68)), (-70, -47), 2.0).rotate([90, 0, 0])
    flat = [box((-41, 41), (35, _JAW_Y + 0.9), (z - 0.8, z + 0.8)) for z in (48.0, 58.0, 68.0)]
    upright = box((-2.2, 2.2), (-2.2, 2.2), (38, 80)).rotate([0, 0, 45]).translate([0, _JAW_Y, 0])
    return plate - recess - union(flat) - upright.translate([22, 0, 0])


def _end_plate() -> Solid:
    arch = np.concatenate([circle(15.5, 48, (0.0, _AXIS_Z)), [(-22.0, 30.0), (22.0, 30.0)]])
    plate = rounded_prism(convex(arch), (-_END_Y[1], -_END_Y[0]), 1.6)
    return plate.rotate([90, 0, 0])


def _slot() -> Solid:
    """The T-slot, with a wide entry next to the end plate where the slider's tongue drops in."""
    top = _BED_Z[1]
    neck = box((-8, 8), (_END_Y[1], _JAW_Y), (top - 5, top + 1))
    cavity = box((-14, 14), (_END_Y[1], _JAW_Y), (top - 8.4, top - 3.6))
    entry = box((-14, 14), (_END_Y[1], -15.0), (top - 8.4, top + 1))
    return union([neck, cavity, entry])


def _stud_hole() -> Solid:
    """The stud's thread in its assembled place, with a chamfered mouth."""
    offset = _HEIGHT / 2 - _VISE_ON_BALL_Z
    # The stud is modelled from the ball's bottom; its thread's phase counts from there.
    cutter = tapped_hole(*STUD_THREAD, (40.0, 58.0), _GAP).translate([0, 0, offset - 28.5])
    return cutter + cylinder(8.6, (-0.01, 2.2), 48, 6.2)


def _screw_to_vise(solid: Solid) -> Solid:
    """From the vise screw's frame to that of the standing vise: z becomes y."""
    x, y, z = SCREW_IN_VISE_MM
    return solid.rotate([-90, 0, 0]).translate([x, y, z + _HEIGHT / 2])


def _end_hole() -> Solid:
    from_z, to_z = (y - SCREW_IN_VISE_MM[1] for y in _END_Y)
    cutter = tapped_hole(*_SCREW_THREAD, (from_z - 1, to_z + 1), _GAP)
    mouth = cylinder(6.8, (-0.01, 1.6), 40, 5.0)
    mouths = mouth.translate([0, 0, from_z]) + mouth.mirror([0, 0, 1]).translate([0, 0, to_z])
    return _screw_to_vise(cutter + mouths)


def _marks() -> Solid:
    """A ruler along one side of the bed, and a pocket in the other."""
    ruler = [
        box((27.3, 30), (y - 0.6, y + 0.6), (31 if i % 2 else 26, 39))
        for i, y in enumerate(range(-36, 33, 6))
    ]
    pocket = rounded_prism(rounded_rectangle((-28, 28), (27, 34), 3), (-40, -25), 1.0)
    return union([*ruler, pocket.rotate([90, 0, 90])])


def vise_slider() -> Solid:
    """The sliding jaw; its frame: x across, y up, z from the face that presses to the screw.

    A plate with round shoulders, a hub for the screw's tip behind, a T-tongue below.
    """
    bottom, top = -_SLIDER_HEIGHT / 2, _SLIDER_HEIGHT / 2
    face, back = -_SLIDER_LENGTH / 2, _SLIDER_LENGTH / 2
    floor = bottom + _TONGUE_TOP
    corners = [(-40, floor), (40, floor), (40, top - 11), (28, top), (-28, top), (-40, top - 11)]
    plate = rounded_prism(convex(np.array(corners, dtype=np.float64)), (face, 3.0), 2.0)
    axis_y = SCREW_IN_VISE_MM[2] - SLIDER_IN_VISE_MM[2]
    arch = np.concatenate([circle(11.5, 40, (0.0, axis_y)), [(-19.0, floor), (19.0, floor)]])
    hub = rounded_prism(convex(arch), (face + 6, back), 1.6)
    tip = cylinder(4.7, (back - 14, back + 1), 40) + cylinder(
        4.7, (back - 1.5, back + 0.01), 40, 6.2
    )
    solid = plate + hub + _tongue(bottom) - tip.translate([0, axis_y, 0])
    return solid - _slider_grooves(face, floor)


def _tongue(bottom: float) -> Solid:
    """A neck and a flange, both a gap narrower than the slot."""
    half = _TONGUE_LENGTH / 2
    neck = box((-8 + _GAP, 8 - _GAP), (bottom + 1, bottom + _TONGUE_TOP + 3), (-half, half))
    flange = capped(rectangle((-14 + _GAP, 14 - _GAP), (-half, half)), (0, 4.0), 0.8)
    return neck + flange.rotate([-90, 0, 0]).translate([0, bottom, 0])


def _slider_grooves(face: float, floor: float) -> Solid:
    """Grooves as on the fixed jaw, and pockets that save plastic on both sides of the hub."""
    flat = [box((-41, 41), (y - 0.8, y + 0.8), (face - 1, face + 0.9)) for y in (-5.5, 4.5, 14.5)]
    upright = box((-2.2, 2.2), (-60, 60), (-2.2, 2.2)).rotate([0, 45, 0]).translate([-22, 0, face])
    pockets = [
        rounded_prism(rounded_rectangle(x, (floor + 6, floor + 22), 3), (-3, 20), 1.5)
        for x in ((-35.0, -21.0), (21.0, 35.0))
    ]
    return union([*flat, upright, *pockets])


def vise_screw() -> Solid:
    """The vise's screw: fluted grip, thread, long plain tip with a groove."""
    grip = fluted_grip(16, 17.0, 0.9, 2.6, (-52, -32), 2.0) + rounded_disc(9.5, (-36, -27), 1.2)
    dish = Solid.sphere(30.0, 64).translate([0, 0, -80.2])
    shaft = screw_shaft(*_SCREW_THREAD, (-28.0, 18.0), 2.0)
    tip = revolved(
        [
            *[(0, 16), (4.2, 16), (4.2, 46), (3.5, 46.7), (3.5, 48.3)],
            *[(4.2, 49), (4.2, 50.2), (2.4, 52), (0, 52)],
        ],
        40,
    )
    return grip - dish + shaft + tip
