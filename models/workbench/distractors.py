"""Things that are no part of any asset: plain industrial shapes, in the manner of T-LESS.

Sockets, connectors, fuses, brackets, knobs, near to symmetric and without texture (Hodan et al.,
"T-LESS", WACV 2017), all from a seed. Built in millimetres.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from snapfit.models.assets.solids import Points, Solid, box, chamfered, circle, cylinder, union
from snapfit.models.assets.solids_plates import plate
from snapfit.models.assets.turned import (
    fluted_grip,
    lobed_grip,
    rectangle,
    revolved,
    rounded_disc,
    rounded_prism,
    rounded_rectangle,
)
from snapfit.models.mesh import Mesh

Rng = np.random.Generator

_ROUND = 28


def distractor_meshes(n: int, rng: Rng) -> tuple[Mesh, ...]:
    """Different shapes, metres, centred on the origin, each kind in its turn."""
    return tuple(_centred(_MAKERS[i % len(_MAKERS)](rng)) for i in range(n))


def _centred(solid: Solid) -> Mesh:
    mesh = solid.to_mesh()
    vertices = np.asarray(mesh.vert_properties)[:, :3] * 0.001
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    faces = np.asarray(mesh.tri_verts).astype(np.int32)
    return Mesh((vertices - middle).astype(np.float32), faces)


def _block(width: float, depth: float, z: tuple[float, float], edge: float) -> Solid:
    outline = rectangle((-width / 2, width / 2), (-depth / 2, depth / 2))
    return chamfered(outline, z, edge)


def _soft(width: float, depth: float, radius: float) -> Points:
    return rounded_rectangle((-width / 2, width / 2), (-depth / 2, depth / 2), radius)


def _socket(rng: Rng) -> Solid:
    """A wall socket: a soft square, a round well, two or three holes, an earth pin."""
    side, high, well = rng.uniform(40, 75), rng.uniform(12, 30), rng.uniform(0.32, 0.42)
    body = rounded_prism(_soft(side, side, 0.12 * side), (0, high), 2.0)
    body -= cylinder(well * side, (0.35 * high, high + 1), _ROUND)
    for x in (-9.5, 9.5):
        body -= cylinder(2.6, (-1, high), 16).translate([x, 0, 0])
    if rng.random() < 0.5:
        body += cylinder(2.4, (0.3 * high, 0.9 * high), 16).translate([0, 0.6 * well * side, 0])
    return body


def _connector(rng: Rng) -> Solid:
    """A housing with a row of openings and a latch."""
    n, pitch = int(rng.integers(2, 7)), rng.uniform(5, 10)
    width, depth, high = (n + 0.7) * pitch, rng.uniform(10, 22), rng.uniform(12, 28)
    body = _block(width, depth, (0, high), 1.0)
    hole = box((-0.3 * pitch, 0.3 * pitch), (-0.27 * depth, 0.27 * depth), (0.4 * high, high + 1))
    body -= union([hole.translate([(i - (n - 1) / 2) * pitch, 0, 0]) for i in range(n)])
    latch = box((-0.25 * width, 0.25 * width), (0, 4), (0.2 * high, 0.8 * high))
    return body + latch.translate([0, depth / 2 - 0.5, 0])


def _fuse(rng: Rng) -> Solid:
    """A fuse or a lamp holder: discs of different width on one axis."""
    z, profile = 0.0, [(0.0, 0.0)]
    for _ in range(int(rng.integers(2, 6))):
        radius, length = rng.uniform(7, 26), rng.uniform(4, 26)
        profile += [(radius, z), (radius, z + length)]
        z += length
    body = revolved([*profile, (0.0, z)], _ROUND)
    if rng.random() < 0.5:
        body -= cylinder(rng.uniform(3, 6), (z - rng.uniform(4, 14), z + 1), 20)
    return body


def _terminal(rng: Rng) -> Solid:
    """A terminal block: steps along a bar, a screw hole and a wire hole a pole."""
    n, pitch = int(rng.integers(2, 6)), rng.uniform(8, 13)
    width, depth, high = n * pitch, rng.uniform(16, 28), rng.uniform(14, 24)
    body = _block(width, depth, (0, 0.6 * high), 0.8)
    body += _block(width, 0.5 * depth, (0.5 * high, high), 0.8)
    cuts = []
    for i in range(n):
        x = (i - (n - 1) / 2) * pitch
        cuts.append(cylinder(0.28 * pitch, (0.5 * high, high + 1), 16).translate([x, 0, 0]))
        wire = cylinder(0.26 * pitch, (-depth, depth), 14).rotate([90, 0, 0])
        cuts.append(wire.translate([x, 0, 0.3 * high]))
    return body - union(cuts)


def _gland(rng: Rng) -> Solid:
    """A cable gland or a fitting: a hexagon between two tubes."""
    size, bore = rng.uniform(9, 20), rng.uniform(0.45, 0.7)
    up, down = rng.uniform(8, 26), rng.uniform(6, 24)
    body = chamfered(circle(1.1 * size, 6), (0, rng.uniform(6, 14)), 1.0)
    body += cylinder(0.85 * size, (0, up + 8), _ROUND) + cylinder(0.75 * size, (-down, 1), _ROUND)
    return body - cylinder(bore * size, (-down - 1, up + 9), 24)


def _bracket(rng: Rng) -> Solid:
    """An angle with holes, with or without a rib."""
    width, long, high = rng.uniform(18, 50), rng.uniform(30, 80), rng.uniform(20, 60)
    wall, hole = rng.uniform(3, 7), rng.uniform(2.2, 5)
    body = box((0, long), (0, width), (0, wall)) + box((0, wall), (0, width), (0, high))
    for x in np.linspace(0.4, 0.8, int(rng.integers(1, 3))) * long:
        body -= cylinder(hole, (-1, wall + 1), 18).translate([x, width / 2, 0])
    lying = cylinder(hole, (-1, wall + 1), 18).rotate([0, 90, 0])
    body -= lying.translate([0, width / 2, 0.65 * high])
    if rng.random() < 0.6:
        rib = np.array([(0.0, 0), (0.5 * long, 0), (0, 0.5 * high)])
        body += plate(rib, (-1.5, 1.5), 0.2).rotate([90, 0, 0]).translate([wall, width / 2, wall])
    return body


def _bar(rng: Rng) -> Solid:
    """A flat arm with round ends and holes: near to two symmetries, and to none."""
    long, wide, high = rng.uniform(60, 170), rng.uniform(10, 24), rng.uniform(4, 12)
    body = rounded_prism(_soft(long, wide, 0.49 * wide), (0, high), 0.8, 2)
    for x in (-0.5 * long + 0.5 * wide, 0.5 * long - 0.5 * wide):
        if rng.random() < 0.8:
            hole = cylinder(rng.uniform(0.15, 0.3) * wide, (-1, high + 1), 20)
            body -= hole.translate([x, 0, 0])
    if rng.random() < 0.5:
        boss = rounded_disc(0.65 * wide, (0, high + rng.uniform(3, 10)), 0.8, _ROUND)
        body += boss.translate([rng.choice((-0.5, 0.0, 0.5)) * (long - wide), 0, 0])
    return body


def _knob(rng: Rng) -> Solid:
    """A grip with lobes or flutes on a shaft."""
    n, reach, high = int(rng.integers(3, 9)), rng.uniform(16, 34), rng.uniform(9, 22)
    if rng.random() < 0.5:
        grip = lobed_grip(n, reach, 0.28 * reach, (0, high), 1.5, 0.55 * reach)
    else:
        grip = fluted_grip(n + 2, reach, 0.12 * reach, 0.35 * reach, (0, high), 1.5)
    shaft = cylinder(rng.uniform(4, 9), (-rng.uniform(0, 60), high / 2), 24)
    return grip + shaft


def _bolt(rng: Rng) -> Solid:
    """A bolt with rings for a thread, its head hexagonal or round."""
    radius, long = rng.uniform(3, 11), rng.uniform(20, 110)
    pitch = 0.5 * radius + 1.0
    body = cylinder(0.85 * radius, (0, long), 24)
    rings = [cylinder(radius, (z, z + 0.55 * pitch), 24) for z in np.arange(2, long - 2, pitch)]
    head = circle(1.8 * radius, 6 if rng.random() < 0.6 else _ROUND)
    return union([body, *rings]) + chamfered(head, (-1.2 * radius, 0.2), 0.6)


def _wheel(rng: Rng) -> Solid:
    """A wheel or a gear with a hub."""
    n, radius, high = int(rng.integers(10, 30)), rng.uniform(14, 38), rng.uniform(6, 16)
    body = cylinder(radius, (0, high), 48)
    if rng.random() < 0.6:
        tooth = box((0.9 * radius, 1.12 * radius), (-0.9 * radius / n, 0.9 * radius / n), (0, high))
        body += union([tooth.rotate([0, 0, 360 * i / n]) for i in range(n)])
    ring = cylinder(0.85 * radius, (0.5 * high, high + 1), 40) - cylinder(0.4 * radius, (0, 40), 24)
    body -= ring
    body += cylinder(0.35 * radius, (0, high + rng.uniform(0, 8)), 24)
    return body - cylinder(rng.uniform(0.1, 0.25) * radius, (-1, 40), 20)


def _case(rng: Rng) -> Solid:
    """An open case with walls inside."""
    width, depth, high = rng.uniform(35, 110), rng.uniform(25, 70), rng.uniform(15, 45)
    wall = rng.uniform(2, 4)
    shell = rounded_prism(_soft(width, depth, 4.0), (0, high), 1.0, 2)
    inner = box(
        (-width / 2 + wall, width / 2 - wall), (-depth / 2 + wall, depth / 2 - wall), (wall, 99)
    )
    body = shell - inner
    for x in rng.uniform(-0.35, 0.35, int(rng.integers(0, 3))) * width:
        rib = box((-1.2, 1.2), (-depth / 2 + 1, depth / 2 - 1), (1, rng.uniform(0.4, 0.9) * high))
        body += rib.translate([x, 0, 0])
    return body


def _cup(rng: Rng) -> Solid:
    """A cap, a cup or a tube."""
    radius, high, wall = rng.uniform(8, 34), rng.uniform(10, 80), rng.uniform(1.5, 4)
    top = radius * rng.uniform(0.7, 1.15)
    body = cylinder(radius, (0, high), 40, top)
    floor = wall if rng.random() < 0.6 else -1.0
    inner = min(radius, top) - wall
    return body - cylinder(inner, (floor, high + 1), 40)


def _plate_with_holes(rng: Rng) -> Solid:
    """A flat plate with holes, and pegs on it."""
    width, depth, high = rng.uniform(40, 130), rng.uniform(25, 80), rng.uniform(3, 9)
    body = rounded_prism(_soft(width, depth, rng.uniform(2, 9)), (0, high), 0.6, 2)
    for _ in range(int(rng.integers(2, 7))):
        x, y = rng.uniform(-0.38, 0.38) * width, rng.uniform(-0.38, 0.38) * depth
        radius = rng.uniform(2, 6)
        if rng.random() < 0.6:
            body -= cylinder(radius, (-1, high + 1), 18).translate([x, y, 0])
        else:
            peg = cylinder(radius, (0, high + rng.uniform(4, 20)), 18)
            body += peg.translate([x, y, 0])
    return body


def _jaw(rng: Rng) -> Solid:
    """A block with a V or a slot in it and a bore."""
    width, depth, high = rng.uniform(30, 90), rng.uniform(24, 60), rng.uniform(16, 50)
    body = _block(width, depth, (0, high), 1.5)
    if rng.random() < 0.5:
        body -= box((-0.15 * width, 0.15 * width), (-99, 99), (0.45 * high, 99))
    else:
        vee = np.array([(0.0, 0.4 * high), (0.32 * width, high + 2), (-0.32 * width, high + 2)])
        body -= plate(vee, (-60, 60), 0.2).rotate([90, 0, 0])
    bore = cylinder(0.14 * high + 1, (-99, 99), 20).rotate([0, 90, 0])
    return body - bore.translate([0, 0, 0.25 * high])


_MAKERS: tuple[Callable[[Rng], Solid], ...] = (
    *(_socket, _connector, _fuse, _terminal, _gland, _bracket, _bar),
    *(_knob, _bolt, _wheel, _case, _cup, _plate_with_holes, _jaw),
)
