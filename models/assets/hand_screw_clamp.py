"""The Hand-Screw Clamp: the parametric model behind the meshes of its asset bundle.

Two long jaws that look alike. Jaw 1 takes the flat heads of two threads in slots that are open to
one side; jaw 2 has plain holes and glides on the threads; two knobs press it down. A pad slips over
the nose of jaw 1. Run

    python -m snapfit.models.assets.hand_screw_clamp

to write the meshes anew. Lengths are millimetres, as printed. Every body frame stands in the middle
of its part's box. Jaws: x to the nose, z to the side that presses. Threads: y from the flat head to
the tip. Knobs: z from the foot to the crown. Pad: z to the jaw's tip, y to the
side that presses.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from snapfit.models.assets.solids import (
    Solid,
    box,
    cylinder,
    prism,
    rounded_polygon,
    union,
    write_ply,
)
from snapfit.models.assets.turned import (
    convex,
    lobed_grip,
    revolved,
    rounded_prism,
    rounded_rectangle,
    screw_shaft,
    tapped_hole,
)

DIRECTORY = Path(__file__).parent / "hand-screw-clamp"

# How the parts stand in the assembled clamp; the manifest says the same in metres.
PAD_ON_JAW_MM = (75.0, 0.0, 10.5)
THREADS_IN_JAW_MM = ((-62.0, 0.0, 59.5), (0.0, 0.0, 59.5))
JAW_2_ON_JAW_1_MM = (0.0, 0.0, 86.0)
KNOB_ON_THREAD_MM = (0.0, 76.0, 0.0)
THREAD_LEAD_MM = 16.0
KNOB_ENGAGED_MM = 28.0

_THREAD = (6.3, 7.5, THREAD_LEAD_MM, 4)
_GAP = 0.4
_HALF_LENGTH, _HALF_WIDTH, _HALF_HEIGHT = 91.0, 19.0, 30.5
_NOSE_X, _NOSE_Z = 52.0, 3.0
_AXES_X = tuple(x for x, _, _ in THREADS_IN_JAW_MM)

_THREAD_LENGTH, _HEAD_LENGTH, _HEAD_HEIGHT = 178.0, 31.0, 9.0
_SHANK_TO = -28.0

_KNOB_HEIGHT = 41.0
_PAD, _PAD_LENGTH, _PAD_FLOOR = 51.0, 45.0, 6.0


def _jaw_blank() -> Solid:
    """What both jaws share: a long block, slanted outside towards a slim nose, hollows behind."""
    top, bottom = _HALF_HEIGHT, -_HALF_HEIGHT
    back, nose = -_HALF_LENGTH, _HALF_LENGTH
    body = [(back, bottom + 7), (back + 7, bottom), (20.0, bottom), (58.0, 16.0), (58.0, top)]
    corners = [*body, (back + 4, top), (back, top - 4)]
    tip = [(15.0, top), (15.0, _NOSE_Z), (nose - 3, _NOSE_Z), (nose, _NOSE_Z + 3), (nose, top - 3)]
    width = (-_HALF_WIDTH, _HALF_WIDTH)
    solid = _across(corners, width, 2.2) + _across([*tip, (nose - 3, top)], width, 2.2)
    groove = box((-2.1, 2.1), (-30, 30), (-2.1, 2.1)).rotate([0, 45, 0]).translate([70, 0, top])
    ridges = [box((x - 0.7, x + 0.7), (-30, 30), (top - 0.8, top + 1)) for x in (60.0, 80.0, 85.0)]
    return solid - groove - union(ridges)


def _across(corners_xz: list[tuple[float, float]], y: tuple[float, float], edge: float) -> Solid:
    """A rounded prism over the hull of points (x, z), across the jaw; round corners."""
    outline = rounded_polygon(convex(np.array(corners_xz) * (1, -1)), edge + 0.3, 5)
    return rounded_prism(outline, y, edge, 4).rotate([-90, 0, 0])


def _hollow(corners_xz: list[tuple[float, float]], side: int, depth: float) -> Solid:
    """A pocket into one side of a jaw."""
    inner, outer = _HALF_WIDTH - depth, _HALF_WIDTH + 9
    return _across(corners_xz, (inner, outer) if side > 0 else (-outer, -inner), 1.5)


def jaw_1() -> Solid:
    """The jaw with the slots for the threads' heads, both open to the same side; one mark."""
    slots = []
    for x in _AXES_X:
        shank = box((-8.0, 8.0), (0, 30), (-40, 40)) + cylinder(8.0, (-40, 40), 48)
        half = _HEAD_LENGTH / 2 + _GAP
        head = box((-half, half), (-7.9, 30), (-40, -_HALF_HEIGHT + _HEAD_HEIGHT + 1.4))
        flare = prism(np.array([(-8.0, 11.0), (8.0, 11.0), (11.5, 20.0), (-11.5, 20.0)]), (-40, 40))
        slots.append((shank + head + flare).translate([x, 0, 0]))
    pocket = _hollow([(-40, -14), (-18, -14), (-18, 16), (-40, 16)], -1, 9)
    front = _hollow([(24, 16), (24, -8), (30, -8), (44, 12), (44, 16)], -1, 9)
    mark = cylinder(2.5, (-1, 1.4), 24).rotate([0, -90, 0]).translate([-_HALF_LENGTH, 0, 18])
    return _jaw_blank() - union([*slots, pocket, front, mark])


def jaw_2() -> Solid:
    """The jaw with round holes and seats for the knobs, finger hollows on a side; two marks."""
    holes = []
    for x in _AXES_X:
        hole = cylinder(8.1, (-40, 40), 48)
        mouth = cylinder(8.1, (_HALF_HEIGHT - 1.5, _HALF_HEIGHT + 0.01), 48, 9.6)
        seat = cylinder(16.0, (-40, -_HALF_HEIGHT + 1.6), 64)
        holes += [part.translate([x, 0, 0]) for part in (hole, mouth, seat)]
    pocket = _hollow([(-44, -12), (-14, -12), (-14, 18), (-44, 18)], 1, 9)
    front = _hollow([(24, 16), (24, -8), (30, -8), (44, 12), (44, 16)], 1, 9)
    fingers = [
        cylinder(6.0, (-40, 40), 40).translate([x, -_HALF_WIDTH - 3.8, 0])
        for x in (-41.0, -29.0, -17.0)
    ]
    mark = cylinder(2.5, (-1, 1.4), 24).rotate([0, -90, 0])
    marks = [mark.translate([-_HALF_LENGTH, y, 18]) for y in (-5, 5)]
    return _jaw_blank() - union([*holes, pocket, front, *fingers, *marks])


def thread() -> Solid:
    """A flat head, a plain shank as far as the slot, a four-start thread to the tip."""
    start = -_THREAD_LENGTH / 2
    outline = np.array(rounded_rectangle((-15.5, 15.5), (-7.5, 7.5), 3.0, 6))
    head = rounded_prism(outline, (start, start + _HEAD_HEIGHT), 1.2, 3)
    shank = cylinder(7.4, (start + 2, _SHANK_TO), 48)
    collar = revolved([(0, 0), (7.4, 0), (6.0, 2), (0, 2)], 48).translate([0, 0, _SHANK_TO - 0.01])
    ridge = screw_shaft(*_THREAD, (_SHANK_TO - 1, -start), 3.0)
    dimples = [
        cylinder(2.2, (start - 1, start + 1.2), 24).translate([x, 0, 0]) for x in (-10.5, 10.5)
    ]
    # Modelled along z; the body's y runs from the head to the tip.
    return (head + shank + collar + ridge - union(dimples)).rotate([-90, 0, 0])


def knob() -> Solid:
    """Four round lobes on a hub with a wide foot, threaded right through."""
    foot, crown = -_KNOB_HEIGHT / 2, _KNOB_HEIGHT / 2
    lobes = lobed_grip(4, 29.5, 9.0, (foot + 12, crown - 5), 3.5, 15.0)
    hub = revolved(
        [
            *[(0, foot), (14.2, foot), (15.2, foot + 1), (15.2, foot + 4), (13.0, foot + 14)],
            *[(13.0, crown - 8), (12.4, crown - 1), (11.4, crown), (0, crown)],
        ],
        64,
    )
    dimples = [
        Solid.sphere(6.0, 40).translate([21.5, 0, crown - 1.2]).rotate([0, 0, 90 * i])
        for i in range(4)
    ]
    offset = KNOB_ON_THREAD_MM[1]
    bore = tapped_hole(*_THREAD, (offset + foot - 1, offset + crown + 1), _GAP)
    mouth = cylinder(9.4, (foot - 0.01, foot + 2.4), 48, 6.7)
    mouths = mouth + cylinder(6.7, (crown - 2.0, crown + 0.01), 48, 8.8)
    return lobes + hub - union(dimples) - bore.translate([0, 0, -offset]) - mouths


def pad() -> Solid:
    """A cap over the nose of jaw 1: V-grooves for round work on top, ribs in front, open sides.

    Its frame: x across the jaw, y to the side that presses, z to the jaw's tip.
    """
    half, length = _PAD / 2, _PAD_LENGTH / 2
    outline = rounded_rectangle((-half, half), (-half, half), 7.0, 8)
    solid = rounded_prism(outline, (-length, length), 2.5, 5)
    nose = (_NOSE_Z - _GAP - PAD_ON_JAW_MM[2], _HALF_HEIGHT + _GAP - PAD_ON_JAW_MM[2])
    width = (-_HALF_WIDTH - _GAP, _HALF_WIDTH + _GAP)
    room = box(width, nose, (-length - 1, length - _PAD_FLOOR + 0.5))
    along = box((-2.6, 2.6), (-2.6, 2.6), (-40, 40)).rotate([0, 0, 45]).translate([8, half, 0])
    cross = box((-40, 40), (-2.6, 2.6), (-2.6, 2.6)).rotate([45, 0, 0]).translate([0, half, 6])
    ribs = [
        box((-40, 40), (y - 1.0, y + 1.0), (length - 1.2, length + 1)) for y in (-17.0, -11.0, -5.0)
    ]
    return solid - union([room, along, cross, *ribs, _pad_openings()])


def _pad_openings() -> Solid:
    """Slots in both sides, so that the cap springs, and a hollow below."""
    half = _PAD / 2
    slot = prism(rounded_rectangle((-14, 10), (2, 12), 4.5), (-40, 40)).rotate([0, 90, 0])
    below = rounded_prism(rounded_rectangle((-15, 15), (-13, 13), 6), (-half - 20, -half + 8), 2.5)
    # From z up to y up.
    return slot + below.rotate([-90, 0, 0])


def parts() -> dict[str, Solid]:
    """The meshes by name, millimetres, in body frames; knob and thread are used twice."""
    return {
        "jaw-1": jaw_1(),
        "jaw-2": jaw_2(),
        "knob": knob(),
        "thread": thread(),
        "pad": pad(),
    }


def main() -> None:
    """Writes the meshes of the bundle."""
    for name, solid in parts().items():
        write_ply(solid, DIRECTORY / f"{name}.ply")


if __name__ == "__main__":
    main()
