"""Building blocks of flat parts: plates with chamfered edges, rounded outlines, gears and racks.

Lengths are millimetres. Outlines are simple polygons (N, 2), counter-clockwise; unlike those of
`solids.chamfered` and `solids.rounded_polygon` they may have corners that point inwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from manifold3d import CrossSection, Manifold, Mesh, triangulate

from snapfit.models.assets.solids import Points, Solid, Span, inset_polygon

_PRESSURE_ANGLE = math.radians(20)
# How far a cutter runs on beyond the faces that it goes through.
_BEYOND = 0.05


def plate(outline: Points, z: Span, chamfer: float) -> Solid:
    """A prism whose lower and upper edges are chamfered."""
    inset = inset_polygon(outline, chamfer)
    low, high = z
    return _loft([(inset, low), (outline, low + chamfer), (outline, high - chamfer), (inset, high)])


def opening(outline: Points, z: Span, chamfer: float) -> Solid:
    """What to take away for a hole through a plate, chamfered where it comes out."""
    wide = inset_polygon(outline, -chamfer - _BEYOND)
    low, high = z
    return _loft(
        [
            *((wide, low - _BEYOND), (outline, low + chamfer)),
            *((outline, high - chamfer), (wide, high + _BEYOND)),
        ]
    )


def _loft(rings: Sequence[tuple[Points, float]]) -> Solid:
    """The solid between rings of equally many corners, each at its height, upwards."""
    n = len(rings[0][0])
    corners = np.concatenate([np.column_stack([ring, np.full(n, z)]) for ring, z in rings])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    faces = [triangulate([rings[0][0]])[:, ::-1]]
    for k in range(0, n * (len(rings) - 1), n):
        faces.append(np.column_stack([k + i, k + j, k + n + j]))
        faces.append(np.column_stack([k + i, k + n + j, k + n + i]))
    faces.append(triangulate([rings[-1][0]]) + n * (len(rings) - 1))
    triangles = np.concatenate(faces).astype(np.uint32)
    return Manifold(Mesh(corners.astype(np.float32), triangles))


def filleted(corners: Sequence[tuple[float, float, float]], step_deg: float = 15.0) -> Points:
    """A polygon with an arc at each corner, inwards or outwards.

    Args:
        corners: x, y and radius of each; 0 stays sharp.
        step_deg: turn from one side of an arc to the next, at most.
    """
    points = np.array([corner[:2] for corner in corners], dtype=np.float64)
    arcs = [
        _arc(points[i - 1], points[i], points[(i + 1) % len(points)], radius, step_deg)
        for i, (_, _, radius) in enumerate(corners)
    ]
    return np.concatenate(arcs)


def _arc(before: Points, corner: Points, after: Points, radius: float, step_deg: float) -> Points:
    if radius == 0:
        return corner[None]
    back, on = before - corner, after - corner
    back, on = back / np.linalg.norm(back), on / np.linalg.norm(on)
    turn = math.pi - math.acos(float(np.clip(back @ on, -1, 1)))
    reach = radius * math.tan(turn / 2)
    bisector = (back + on) / np.linalg.norm(back + on)
    center = corner + bisector * math.hypot(radius, reach)
    start, end = corner + back * reach - center, corner + on * reach - center
    shares = np.linspace(0, 1, math.ceil(math.degrees(turn) / step_deg) + 1)[:, None]
    arc: Points = (np.sin((1 - shares) * turn) * start + np.sin(shares * turn) * end) / math.sin(
        turn
    )
    return center + arc


def rectangle(x: Span, y: Span, radius: float = 0.0) -> Points:
    """A rectangle, its corners rounded."""
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    return filleted([(*corner, radius) for corner in corners])


def convex_outline(*points: Points) -> Points:
    """The convex hull of sets of points (N, 2)."""
    hull = CrossSection.hull_points(np.concatenate(points))
    return np.array(hull.to_polygons()[0], dtype=np.float64)


def stadium(x: Span, y: float, radius: float, steps: int = 12) -> Points:
    """A slot along x between two round ends, whose outermost points are at `x`."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, steps + 1)
    end = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    right, left = np.array([x[1] - radius, y]) + end, np.array([x[0] + radius, y]) - end
    return np.concatenate([right, left])


def gear_outline(n_teeth: int, module: float = 1.0, play: float = 0.12) -> Points:
    """A spur gear with involute flanks; a tooth stands at angle 0.

    Args:
        n_teeth: around.
        module: pitch diameter / teeth.
        play: how much narrower a tooth is than its gap, on the pitch circle.
    """
    pitch_radius = module * n_teeth / 2
    base_radius = pitch_radius * math.cos(_PRESSURE_ANGLE)
    root, tip = pitch_radius - 1.25 * module, pitch_radius + 0.95 * module
    half = math.pi / (2 * n_teeth) - play / 2 / pitch_radius + _involute(_PRESSURE_ANGLE)
    radii = np.linspace(max(root + 0.15 * module, base_radius), tip, 4)
    angles = [half - _involute(math.acos(min(base_radius / radius, 1.0))) for radius in radii]
    foot = angles[0] + 0.02
    profile = [(root, foot), *zip(radii, angles, strict=True)]
    tooth = [(radius, -angle) for radius, angle in profile]
    tooth += [(radius, angle) for radius, angle in reversed(profile)]
    turns = np.add.outer(np.arange(n_teeth) * 2 * math.pi / n_teeth, [angle for _, angle in tooth])
    lengths = np.tile([radius for radius, _ in tooth], n_teeth)
    directions = np.column_stack([np.cos(turns.ravel()), np.sin(turns.ravel())])
    outline: Points = directions * lengths[:, None]
    return outline


def _involute(angle: float) -> float:
    return math.tan(angle) - angle


def rack_line(n_teeth: int, tooth_at: float, tip: float, play: float = 0.12) -> Points:
    """The upper edge of a rack of module 1 from right to left, without its ends.

    Args:
        n_teeth: all of them.
        tooth_at: x of the middle of the leftmost tooth.
        tip: y of the tips; the pitch line lies 1 below.
        play: how much narrower a tooth is than its gap, on the pitch line.
    """
    slope = math.tan(_PRESSURE_ANGLE)
    half = math.pi / 4 - play / 2
    top, foot = half - slope, half + 1.25 * slope
    points = []
    for i in reversed(range(n_teeth)):
        x = tooth_at + math.pi * i
        points += [(x + foot, tip - 2.25), (x + top, tip), (x - top, tip), (x - foot, tip - 2.25)]
    return np.array(points)


def axis_angle(center_distance: float, across: float) -> tuple[float, float]:
    """Offset and angle (rad) to a gear whose axis lies `across` higher and to the right."""
    along = math.sqrt(center_distance**2 - across**2)
    return along, math.atan2(across, along)
