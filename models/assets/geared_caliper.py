"""The Geared Caliper: the parametric model behind the meshes of its asset bundle.

A flat fixed jaw whose beam carries a rack; a slide with the other jaw, in whose channel the beam
runs; three gears, one of them the thumb roller that meshes with the rack, on the posts of the slide
and of the cover; a cover with the vernier's window and a dial that shuts the slide. Run

    python -m snapfit.models.assets.geared_caliper

to write the meshes anew. Lengths are millimetres, as printed. All parts are modelled where they
stand in the closed caliper: x along the beam, 0 at the measuring faces, y up from the beam's lower
edge, z up from the slide's back. Body frames stand in the middle of a part's box, those of the
gears on their axes; y and z of the fixed jaw and of the cover lie across and along the jaws.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from snapfit.models.assets.solids import (
    Solid,
    box,
    circle,
    cylinder,
    prism,
    union,
    write_ply,
)
from snapfit.models.assets.solids_plates import (
    axis_angle,
    filleted,
    gear_outline,
    opening,
    plate,
    rack_line,
    rectangle,
    stadium,
)

DIRECTORY = Path(__file__).parent / "geared-caliper"

# How far the jaws stand apart in the assembled caliper, and at most.
OPENED_MM, OPENED_MOST_MM = 20.0, 75.0
FIX_TRAVEL_MM = (OPENED_MM - OPENED_MOST_MM, OPENED_MM)

_TOP, _TIP, _BEAM, _BEAM_TO, _TAIL = 36.0, -74.0, 26.0, 177.0, -30.0
_FIX_Z = (4.8, 9.8)
_GAP = 0.3
_FLOOR, _DECK, _RIDGE = 4.6, 10.0, 17.0
_SLIDE_TO, _SLIDE_BOTTOM = 90.0, -18.0
_COVER_X, _COVER_Y, _COVER_Z = (20.0, 85.0), (-16.0, 30.0), (4.2, 21.2)
_SILL, _ROOF = 10.1, (15.4, 17.6)

_LARGE_TEETH, _SMALL_TEETH, _WHEEL_TEETH, _PINION_TEETH = 36, 12, 20, 12
_LARGE_AT = (50.0, 9.0)
_ROLLER_Y, _SMALL_Y = _BEAM - 1 + _PINION_TEETH / 2, -7.0
_ROLLER_DX, _ROLLER_RAD = axis_angle((_LARGE_TEETH + _WHEEL_TEETH) / 2, _ROLLER_Y - _LARGE_AT[1])
_SMALL_DX, _SMALL_RAD = axis_angle((_LARGE_TEETH + _SMALL_TEETH) / 2, _LARGE_AT[1] - _SMALL_Y)
_ROLLER_AT = (_LARGE_AT[0] + _ROLLER_DX, _ROLLER_Y)
_SMALL_AT = (_LARGE_AT[0] - _SMALL_DX, _SMALL_Y)
_GEAR_Z = (10.3, 14.3)
_ROLLER_Z, _HUB_TO = (4.9, 15.0), 17.4

# Middles of the boxes; where the frames of the gears stand.
ORIGIN_MM = {
    "fix": ((_TAIL + _BEAM_TO) / 2 - OPENED_MM, (_TOP + _TIP) / 2, sum(_FIX_Z) / 2),
    "move-bottom": (_SLIDE_TO / 2, (_TOP + _TIP) / 2, 8.5),
    "move-top-vernier": (sum(_COVER_X) / 2, sum(_COVER_Y) / 2, sum(_COVER_Z) / 2),
    "gear-large": (*_LARGE_AT, sum(_GEAR_Z) / 2),
    "gear-small": (*_SMALL_AT, (_GEAR_Z[0] + _HUB_TO) / 2),
    "roller": (*_ROLLER_AT, sum(_ROLLER_Z) / 2),
}


def gear_turn_rad() -> dict[str, float]:
    """How far each gear is turned about its axis so that its teeth stand in the others' gaps.

    Where two gears touch, the phases of their teeth add up to half a tooth.
    """
    turn = {"gear-large": 0.0}
    for name, n_teeth, toward in (
        ("roller", _WHEEL_TEETH, _ROLLER_RAD),
        ("gear-small", _SMALL_TEETH, math.pi + _SMALL_RAD),
    ):
        phase = (0.5 - toward * _LARGE_TEETH / (2 * math.pi)) % 1
        turn[name] = toward + math.pi - 2 * math.pi / n_teeth * phase
        turn[name] %= 2 * math.pi / n_teeth
    return turn


def _rack_tooth_at() -> float:
    """Where (x) some tooth of the rack stands, jaws closed: the pinion's are in its gaps."""
    turn = gear_turn_rad()["roller"]
    phase = (-math.pi / 2 - turn) * _PINION_TEETH / (2 * math.pi)
    # The nearest pinion tooth is ahead by its phase, measured along the pitch line.
    gap_at = _ROLLER_AT[0] + OPENED_MM - math.pi * (phase % 1)
    return gap_at + math.pi / 2


def fix() -> Solid:
    """The fixed jaw: an L-shaped plate with rack, slot, windows and a scale. Jaws closed."""
    n_teeth = 40
    first = _rack_tooth_at()
    first -= math.pi * math.floor((first - 44.0) / math.pi)
    rack = rack_line(n_teeth, first, _BEAM)
    outline = filleted(
        [
            *((-8, _TIP, 1.2), (0, _TIP, 1.2), (0, -3, 0), (-2, -3, 0.9), (-2, 0, 0), (2, 0, 0)),
            *((_BEAM_TO, 0, 6), (_BEAM_TO, _BEAM, 6), *((x, y, 0) for x, y in rack)),
            *((40, _BEAM, 0), (-1, _BEAM, 1.5), (-3, _TOP, 1.5), (-15, _TOP, 4)),
            *((_TAIL, 24, 8), (_TAIL, -6, 14)),
        ]
    )
    solid = plate(outline, _FIX_Z, 0.4)
    holes = [
        stadium((44, 129), _LARGE_AT[1] + 4, 4.2),
        stadium((137, 162), _LARGE_AT[1] + 4, 5.0),
        filleted([(-23, -8, 3), (-12, -46, 2), (-7, -48, 2), (-7, -8, 3)]),
        stadium((4, 36), _LARGE_AT[1] + 4, 4.2),
        circle(4, 32, (-17, 17)),
    ]
    marks = [
        box((x - 0.35, x + 0.35), (-1, 3.9 if x % 10 == 0 else 2.5), (_FIX_Z[1] - 0.5, 20))
        for x in range(5, 165, 5)
    ]
    return solid - union([opening(hole, _FIX_Z, 0.4) for hole in holes]) - union(marks)


def move_bottom() -> Solid:
    """The slide: jaw, channel for the beam, posts, a ridge, seats for the cover's pegs."""
    outline = filleted(
        [
            *((0, _TIP, 1.2), (9, _TIP, 2), (26, _SLIDE_BOTTOM - 8, 12), (34, _SLIDE_BOTTOM, 8)),
            *((_SLIDE_TO, _SLIDE_BOTTOM, 7), (_SLIDE_TO, _TOP, 9), (12, _TOP, 6), (0, 28, 3)),
        ]
    )
    solid = plate(outline, (0, _DECK), 1.0)
    channel = box((-9, 99), (-_GAP, _BEAM + _GAP), (_FLOOR, 20))
    pocket = cylinder(7.8, (_FLOOR, 20), 48).translate([*_ROLLER_AT, 0])
    jaw_pocket = opening(
        filleted([(5, -22, 2), (5, -58, 1.5), (9, -58, 1.5), (20, -22, 3)]), (7, _DECK), 0.6
    )
    jaw_pocket = jaw_pocket ^ box((-50, 99), (-99, 99), (7, 20))
    seats = [cylinder(2.8, (4.0, 20), 32).translate([x, -12.5, 0]) for x in (24, 81)]
    groove = box((23.7, 38.3), (27.3, 29.9), (4.0, 20))
    grips = [
        cylinder(2.2, (-5, 20), 24).translate([x, _SLIDE_BOTTOM - 0.9, 0]) for x in range(52, 82, 6)
    ]
    windows = [
        opening(stadium((8, 30), _LARGE_AT[1], 6), (0, _FLOOR), 0.5),
        opening(stadium((62, 84), _LARGE_AT[1], 6), (0, _FLOOR), 0.5),
    ]
    relief = prism(rectangle((-3, 2), (-4, 2)), (-1, 20))
    solid = solid - union([channel, pocket, jaw_pocket, *seats, groove, *grips, *windows, relief])
    ridge = plate(rectangle((14, 95), (_COVER_Y[1] + 0.6, _TOP + 9), 3), (5, _RIDGE), 1.2)
    ridge = ridge ^ plate(outline, (0, _RIDGE), 1.0)
    notch = cylinder(_WHEEL_TEETH / 2 + 1.9, (_DECK, 20), 60).translate([*_ROLLER_AT, 0])
    roller_post = _post(2.5, _FLOOR, 14.6).translate([*_ROLLER_AT, 0])
    small_post = _post(1.6, _DECK, 14.6).translate([*_SMALL_AT, 0])
    return solid + (ridge - notch - pocket) + roller_post + small_post


def _post(radius: float, start: float, end: float) -> Solid:
    tip = cylinder(radius, (end - 0.8, end), 32, radius - 0.7)
    return cylinder(radius, (start - 1, end - 0.8), 32) + tip


def move_top_vernier() -> Solid:
    """The cover: a shell open for the roller, with dial, window, axle, pegs and tongue."""
    outline = rectangle(_COVER_X, _COVER_Y, 6)
    solid = plate(outline, (_SILL, _ROOF[1]), 1.0)
    inner = rectangle((_COVER_X[0] + 2, _COVER_X[1] - 2), (_COVER_Y[0] + 2, _COVER_Y[1] - 2), 4)
    cavity = prism(inner, (0, _ROOF[0]))
    dial = plate(circle(18.5, 72), (_ROOF[1] - 1, _COVER_Z[1]), 0.8) - opening(
        circle(13.5, 60), (_ROOF[1], _COVER_Z[1]), 0.8
    )
    ticks = [
        box((14.5, 30), (-0.4, 0.4), (_COVER_Z[1] - 0.7, 30)).rotate([0, 0, angle])
        for angle in range(0, 360, 24)
    ]
    dial = (dial - union(ticks)).translate([*_LARGE_AT, 0])
    pegs = [_peg().translate([x, -12.5, 0]) for x in (24, 81)]
    tongue = box((24, 38), (27.6, 29.6), (_COVER_Z[0], _ROOF[0]))
    axle = _post(3.5, -_ROOF[0] - 1, -_GEAR_Z[0] + 0.3).mirror([0, 0, 1]).translate([*_LARGE_AT, 0])
    return (solid - cavity + union([dial, *pegs, tongue])) - _cover_openings() + axle


def _peg() -> Solid:
    low = _COVER_Z[0]
    return cylinder(2.5, (low + 0.8, _ROOF[0] + 0.5), 32) + cylinder(1.8, (low, low + 0.8), 32, 2.5)


def _cover_openings() -> Solid:
    window = opening(rectangle((71.5, 81), (-3, 13), 1.5), _ROOF, 1.6)
    ticks = [
        box((x - 0.3, x + 0.3), (-9, -5.6), (_ROOF[1] - 0.5, 20)) for x in np.arange(72.0, 82, 1.8)
    ]
    wheel = cylinder(_WHEEL_TEETH / 2 + 1.8, (_SILL - 1, _ROOF[0]), 48)
    gear = cylinder(_LARGE_TEETH / 2 + 1.4, (_SILL - 1, _ROOF[0]), 72)
    pointer = opening(circle(4.4, 36), _ROOF, 0.5)
    beam = box((0, 99), (-_GAP, _BEAM + _GAP), (0, _SILL + 0.3))
    grips = [
        cylinder(1.3, (0, 30), 20).translate([x, _COVER_Y[0] - 0.4, 0]) for x in range(42, 69, 4)
    ]
    return union(
        [
            *(window, *ticks, beam, *grips),
            wheel.translate([*_ROLLER_AT, 0]),
            gear.translate([*_LARGE_AT, 0]),
            pointer.translate([*_SMALL_AT, 0]),
        ]
    )


def gear_large() -> Solid:
    """The gear behind the dial, with six windows."""
    solid = plate(gear_outline(_LARGE_TEETH), _GEAR_Z, 0.3)
    hub = plate(circle(6.5, 40), (_GEAR_Z[0], _GEAR_Z[1] + 0.8), 0.3)
    windows = [
        opening(circle(3.6, 28, (11.3, 0)), _GEAR_Z, 0.4).rotate([0, 0, 60 * i]) for i in range(6)
    ]
    bore = cylinder(3.8, (0, 30), 36)
    return solid + hub - union(windows) - bore


def gear_small() -> Solid:
    """The pointer's gear: its hub shows through the cover and is slotted."""
    hub = plate(circle(4.0, 36), (_GEAR_Z[1] - 1, _HUB_TO), 0.5)
    slot = box((-0.6, 9), (-0.6, 0.6), (_HUB_TO - 1, 30))
    solid = plate(gear_outline(_SMALL_TEETH), _GEAR_Z, 0.3) + hub
    return solid - slot - cylinder(1.9, (0, 14.9), 28)


def roller() -> Solid:
    """The thumb roller: a toothed wheel on the pinion that meshes with the rack."""
    wheel = plate(gear_outline(_WHEEL_TEETH), (_GEAR_Z[0], _ROLLER_Z[1]), 0.3)
    pinion = plate(gear_outline(_PINION_TEETH), (_ROLLER_Z[0], _GEAR_Z[0] + 0.5), 0.2)
    recess = plate(circle(6.5, 40), (_ROLLER_Z[1] - 0.8, 30), 0.3)
    return wheel + pinion - recess - cylinder(2.8, (0, 30), 32)


def _into_frame(name: str, solid: Solid) -> Solid:
    """From where it stands in the closed caliper to its body frame."""
    solid = solid.translate([-value for value in ORIGIN_MM[name]])
    if name in ("fix", "move-top-vernier"):
        return solid.rotate([90, 0, 0])
    return solid


def parts() -> dict[str, Solid]:
    """The parts by name, millimetres, each in its body frame."""
    placed = {
        "fix": fix().translate([-OPENED_MM, 0, 0]),
        "move-bottom": move_bottom(),
        "move-top-vernier": move_top_vernier(),
    }
    solids = {name: _into_frame(name, solid) for name, solid in placed.items()}
    gears = {"gear-large": gear_large(), "gear-small": gear_small(), "roller": roller()}
    for name, gear in gears.items():
        solids[name] = gear.translate([0, 0, -ORIGIN_MM[name][2]])
    return solids


def main() -> None:
    """Writes the meshes of the bundle."""
    for name, solid in parts().items():
        write_ply(solid, DIRECTORY / f"{name}.ply")


if __name__ == "__main__":
    main()
