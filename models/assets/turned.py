"""Building blocks with soft edges: turned bodies, rounded prisms, grips, screws. Millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from manifold3d import CrossSection, Manifold

from snapfit.models.assets.solids import (
    Points,
    Solid,
    Span,
    circle,
    cylinder,
    hull,
    inset_polygon,
    prism,
    rounded_polygon,
    thread,
    union,
)


def rectangle(x: Span, y: Span) -> Points:
    """(4, 2) corners of a rectangle, counter-clockwise."""
    return np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])], dtype=np.float64)


def rounded_rectangle(x: Span, y: Span, radius: float, steps: int = 6) -> Points:
    """A rectangle (N, 2) with round corners, counter-clockwise."""
    return rounded_polygon(rectangle(x, y), radius, steps)


def revolved(profile: Sequence[tuple[float, float]], segments: int = 48) -> Solid:
    """A body turned about z from its half section, corners (radius, z), counter-clockwise."""
    return Manifold.revolve(CrossSection([np.array(profile, dtype=np.float64)]), segments)


def rounded_prism(outline: Points, z: Span, radius: float, steps: int = 4) -> Solid:
    """A prism over a convex, counter-clockwise polygon (N, 2), its upper and lower edges round."""
    rings = []
    for angle in np.linspace(0, math.pi / 2, steps + 1):
        ring = inset_polygon(outline, radius * (1 - math.cos(angle)))
        rise = radius * (1 - math.sin(angle))
        rings += [(ring, z[0] + rise), (ring, z[1] - rise)]
    return hull(*rings)


def capped(outline: Points, z: Span, radius: float, steps: int = 4) -> Solid:
    """As `rounded_prism`, but only the upper edge is round."""
    body = rounded_prism(outline, (z[0] - 2 * radius, z[1]), radius, steps)
    return body ^ prism(outline, z)


def rounded_disc(radius: float, z: Span, edge: float, segments: int = 48) -> Solid:
    """A disc about z with round edges."""
    return rounded_prism(circle(radius, segments), z, edge)


def lobed_grip(
    lobes: int, reach: float, lobe_radius: float, z: Span, edge: float, hub: float
) -> Solid:
    """Arms with round ends around z; the first points along x and ends at `reach`."""
    outline = np.concatenate([circle(hub, 32), circle(lobe_radius, 32, (reach - lobe_radius, 0.0))])
    arm = rounded_prism(convex(outline), z, edge)
    return union([arm.rotate([0, 0, 360 / lobes * i]) for i in range(lobes)])


def fluted_grip(
    flutes: int, radius: float, depth: float, flute_radius: float, z: Span, edge: float
) -> Solid:
    """A disc about z with hollows for the fingers around it; between two of them lies x."""
    cutter = cylinder(flute_radius, (z[0] - 1, z[1] + 1), 32)
    cutter = cutter.translate([radius - depth + flute_radius, 0, 0])
    turns = [360 / flutes * (i + 0.5) for i in range(flutes)]
    return rounded_disc(radius, z, edge, 64) - union([cutter.rotate([0, 0, a]) for a in turns])


def convex(points: Points) -> Points:
    """The corners (N, 2) of the convex hull of points, counter-clockwise."""
    hulled: Points = np.asarray(CrossSection.hull_points(points).to_polygons()[0], dtype=np.float64)
    return hulled


def screw_shaft(
    root: float, crest: float, lead: float, starts: int, z: Span, tapered: float = 2.5
) -> Solid:
    """A threaded shaft along z whose upper end is tapered, so that it finds its nut."""
    ridge = thread(root, crest, lead, starts, z, arc_points=3, step_deg=20)
    envelope = cylinder(crest + 0.1, (z[0], z[1] - tapered), 48)
    return ridge ^ (envelope + cylinder(crest + 0.1, (z[1] - tapered, z[1]), 48, root - 0.3))


def tapped_hole(root: float, crest: float, lead: float, starts: int, z: Span, gap: float) -> Solid:
    """What to cut away so that `screw_shaft` with the same numbers turns in it."""
    return thread(root + gap, crest + gap, lead, starts, z, arc_points=3, step_deg=20)
