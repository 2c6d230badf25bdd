"""The Nano Chuck: the parametric model behind the meshes of its asset bundle.

A small vise on a ball joint. The base clamps with a long screw and a swivelling headplate to the
edge of a board; the ball stands in a slit cup and is held by a nut; the vise (see
`nano_chuck_vise`) is screwed on its stud. Run

    python -m snapfit.models.assets.nano_chuck

to write the meshes anew. Lengths are millimetres, as printed. The base is modelled with its bottom
at z = 0 and the clamping screw along x. Every body frame stands in the middle of its part's box;
turned parts have their axis along z, screws run from the knob to the tip.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from snapfit.models.assets import nano_chuck_vise as vise
from snapfit.models.assets.solids import (
    Solid,
    box,
    circle,
    cylinder,
    prism,
    union,
    write_ply,
)
from snapfit.models.assets.turned import (
    convex,
    fluted_grip,
    lobed_grip,
    revolved,
    rounded_disc,
    rounded_prism,
    rounded_rectangle,
    screw_shaft,
    tapped_hole,
)

DIRECTORY = Path(__file__).parent / "nano-chuck"

# How the parts stand in the assembled chuck; the manifest says the same in metres.
SCREW_IN_BASE_MM = (-101.0, 10.0, 10.0)
HEADPLATE_ON_SCREW_MM = (0.0, 0.0, 63.0)
BALL_IN_BASE_MM = (51.5, 0.0, 29.5)
NUT_IN_BASE_MM = (51.5, 0.0, 18.5)
VISE_ON_BALL_MM = (0.0, 0.0, 51.4)

SCREW_LEAD_MM, NUT_LEAD_MM = 20.0, 24.0
_SCREW_THREAD = (5.7, 6.8, SCREW_LEAD_MM, 4)
_NUT_THREAD = (22.1, 23.5, NUT_LEAD_MM, 8)
_GAP = 0.4

_HEIGHT = 40.0
_CUP = BALL_IN_BASE_MM[:2]
_CUP_FLOOR_Z, _BALL_Z = 20.0, 38.0
_BALL_RADIUS, _BALL_FLAT = 18.0, 17.0
_BOSS_X = (-82.5, -58.0)
_SCREW_Y, _SCREW_Z = SCREW_IN_BASE_MM[1], SCREW_IN_BASE_MM[2] + _HEIGHT / 2
_TIP_RADIUS, _TIP_Z = 6.0, 59.5


def base() -> Solid:
    """The base: foot with a slit cup, anvil, spine, threaded boss for the clamping screw."""
    foot = rounded_prism(rounded_rectangle((8, 82.5), (-41, 41), 12), (0, 20), 2.5)
    spine = rounded_prism(rounded_rectangle((-82.5, 30), (-41, -20), 6), (0, 24), 2.5)
    solid = union([foot, spine, _anvil(), _boss(), _cup()]) - _cup_hollow() - _boss_hole()
    return (solid - _base_holes()).translate([0, 0, -_HEIGHT / 2])


def _along_x(outline_yz: list[tuple[float, float]], x: tuple[float, float], edge: float) -> Solid:
    """A rounded prism over the hull of points (y, z), from one x to another."""
    outline = convex(np.array(outline_yz))
    return rounded_prism(outline, x, edge, 3).rotate([90, 0, 90])


def _anvil() -> Solid:
    """The fixed plate against which the headplate presses, with grooves for grip."""
    plate = _along_x([(-40, 0), (36, 0), (36, 34), (30, 40), (-24, 40), (-40, 24)], (8, 20), 2.0)
    grooves = [box((7, 9), (-18, 34), (z - 0.9, z + 0.9)) for z in (16.0, 22.0, 28.0, 34.0)]
    return plate - union(grooves)


def _boss() -> Solid:
    """The arm that carries the screw: a round head around its axis on a wide foot."""
    head = [(float(y) + _SCREW_Y, float(z) + _SCREW_Z) for y, z in circle(10.0, 40)]
    arm = _along_x([(-41, 0), (-41, 24), (30, 24), (36, 0)], _BOSS_X, 2.5)
    return arm + _along_x([*head, (-14, 4), (34, 4)], _BOSS_X, 1.2)


def _cup() -> Solid:
    """The cup with its outer thread, tapered at the rim."""
    shaft = screw_shaft(*_NUT_THREAD, (_CUP_FLOOR_Z - 4, _HEIGHT), 1.5)
    return shaft.translate([*_CUP, 0])


def _cup_hollow() -> Solid:
    """Room for the ball, dropped in from above, and the slits that let the nut squeeze it."""
    room = _BALL_RADIUS + _GAP
    hollow = Solid.sphere(room, 64).translate([0, 0, _BALL_Z])
    hollow = hollow ^ cylinder(room, (_CUP_FLOOR_Z, _BALL_Z), 64)
    hollow = hollow + cylinder(room, (_BALL_Z - 0.1, _HEIGHT + 1), 64)
    slit = box((-30, 30), (-1.3, 1.3), (_CUP_FLOOR_Z + 4, _HEIGHT + 1))
    return (hollow + slit.rotate([0, 0, 45]) + slit.rotate([0, 0, -45])).translate([*_CUP, 0])


def _screw_to_base(solid: Solid) -> Solid:
    """From the screw's frame to that of the standing base: z, x, y become x, y, z."""
    x, y, z = SCREW_IN_BASE_MM
    return solid.rotate([90, 0, 90]).translate([x, y, z + _HEIGHT / 2])


def _boss_hole() -> Solid:
    """The screw's thread in its assembled place, and chamfers at both mouths."""
    from_z, to_z = (x - SCREW_IN_BASE_MM[0] for x in _BOSS_X)
    cutter = tapped_hole(*_SCREW_THREAD, (from_z - 1, to_z + 1), _GAP)
    mouth = cylinder(8.2, (-0.01, 2), 48, 5.7)
    mouths = mouth.translate([0, 0, from_z]) + mouth.mirror([0, 0, 1]).translate([0, 0, to_z])
    return _screw_to_base(cutter + mouths)


def _base_holes() -> Solid:
    """Screw holes with countersinks in the foot, windows in the spine, a notch that tells sides."""
    screw = cylinder(2.6, (-1, 25), 24) + cylinder(2.6, (16.6, 20.01), 24, 6.0)
    spots = [(74.0, 32.0), (74.0, -32.0), (29.0, -32.0), (29.0, 32.0)]
    holes = [screw.translate([x, y, 0]) for x, y in spots]
    windows = [
        prism(rounded_rectangle(x, (-35.5, -25.5), 4.5), (-1, 30))
        for x in ((-52.0, -36.0), (-32.0, -16.0), (-12.0, 4.0))
    ]
    notch = cylinder(6, (-1, 25), 32).translate([83.5, 0, 0])
    return union([*holes, *windows, notch])


def screw() -> Solid:
    """The clamping screw: cross knob, four-start thread, ball tip on a thin neck."""
    knob = lobed_grip(4, 29.0, 7.0, (-65.5, -47.0), 2.5, 12.0)
    knob = knob + rounded_disc(14.5, (-64.0, -43.5), 2.0)
    dimple = Solid.sphere(9.0, 48).translate([0, 0, -70.5])
    marks = [
        cylinder(2.6, (-66, -63.8), 20).translate([22.0, 0, 0]).rotate([0, 0, 90 * i])
        for i in range(4)
    ]
    shaft = screw_shaft(*_SCREW_THREAD, (-45.0, 52.0))
    neck = cylinder(4.0, (51, 58), 32)
    tip = Solid.sphere(_TIP_RADIUS, 40).translate([0, 0, _TIP_Z])
    return knob - dimple - union(marks) + shaft + neck + tip


def headplate() -> Solid:
    """The square plate that swivels on the screw's tip: socket behind, crossed grooves in front."""
    plate = rounded_prism(rounded_rectangle((-22, 22), (-22, 22), 8, 8), (-1, 8), 2.0, 5)
    boss = revolved([(0, -8), (10.0, -8), (11.0, -7), (11.0, -3), (15.0, 0.5), (0, 0.5)], 48)
    groove = box((-30, 30), (-2, 2), (-2, 2)).rotate([45, 0, 0]).translate([0, 0, 8.6])
    rims = [
        box((-30, 30), (y - 0.7, y + 0.7), (7.2, 9)).rotate([0, 0, turn])
        for y in (-12.0, 12.0)
        for turn in (0, 90)
    ]
    socket_z = _TIP_Z - HEADPLATE_ON_SCREW_MM[2]
    socket = Solid.sphere(_TIP_RADIUS + _GAP, 48).translate([0, 0, socket_z])
    mouth = cylinder(6.6, (-8.01, -6.5), 48, 5.2) + cylinder(5.2, (-7, socket_z), 48)
    return plate + boss - groove - groove.rotate([0, 0, 90]) - union(rims) - socket - mouth


def balljoint() -> Solid:
    """The ball with a flat below; above it a neck, a collar, and the stud for the vise."""
    start = math.asin(-_BALL_FLAT / _BALL_RADIUS)
    end = math.acos(8.0 / _BALL_RADIUS)
    angles = np.linspace(start, end, 28)
    ball = [(_BALL_RADIUS * math.cos(a), _BALL_FLAT + _BALL_RADIUS * math.sin(a)) for a in angles]
    collar = [(8.0, 35.0), (11.0, 37.0), (11.0, 40.2), (10.2, 41.0), (0.0, 41.0)]
    body = revolved([(0.0, 0.0), *ball, *collar], 64)
    stud = screw_shaft(*vise.STUD_THREAD, (40.0, 57.0), 2.0)
    return (body + stud).translate([0, 0, -28.5])


def nut() -> Solid:
    """The nut over the cup: hollows for the fingers, inner thread, a round seat on the ball."""
    z = NUT_IN_BASE_MM[2] + _HEIGHT / 2
    bottom, top = z - 12.5, z + 12.5
    grip = fluted_grip(8, 29.5, 2.6, 7.0, (bottom, bottom + 17.5), 2.0)
    dome = revolved(
        [
            (0, bottom + 15),
            (26.0, bottom + 15),
            (25.2, bottom + 19),
            (22.5, top - 1.6),
            (19.5, top),
            (0, top),
        ],
        64,
    )
    bore = tapped_hole(*_NUT_THREAD, (bottom - 1, _HEIGHT + 1), _GAP)
    mouth = cylinder(25.2, (bottom - 0.01, bottom + 2.4), 64, 22.5)
    seat = Solid.sphere(_BALL_RADIUS + _GAP, 64).translate([0, 0, _BALL_Z])
    opening = cylinder(12.6, (top - 6, top + 1), 64) + cylinder(13, (top - 2, top + 0.01), 64, 16)
    solid = grip + dome - bore - mouth - (seat ^ cylinder(30, (_HEIGHT, top + 1), 64)) - opening
    return solid.translate([0, 0, -z])


def parts() -> dict[str, Solid]:
    """The parts by name, millimetres, each in its body frame."""
    return {
        "base": base(),
        "screw": screw(),
        "headplate": headplate(),
        "balljoint": balljoint(),
        "nut": nut(),
        "vise-base": vise.vise_base(),
        "vise-slider": vise.vise_slider(),
        "vise-screw": vise.vise_screw(),
    }


def main() -> None:
    """Writes the meshes of the bundle."""
    for name, solid in parts().items():
        write_ply(solid, DIRECTORY / f"{name}.ply")


if __name__ == "__main__":
    main()
