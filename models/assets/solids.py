"""Building blocks of the parametric parts: chamfered prisms, arms, threads. Millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import trimesh
from manifold3d import CrossSection, Manifold

# manifold3d's stubs are not read by the type checker.
Solid: TypeAlias = Manifold
Points = npt.NDArray[np.float64]
Span = tuple[float, float]

# Two vertices nearer than this become one, so that a mesh has no needles.
_SMALLEST_EDGE_MM = 0.01


def box(x: Span, y: Span, z: Span) -> Solid:
    """A box between two numbers on each axis."""
    size = [span[1] - span[0] for span in (x, y, z)]
    return Manifold.cube(size).translate([x[0], y[0], z[0]])


def cylinder(radius: float, z: Span, segments: int = 48, top_radius: float | None = None) -> Solid:
    """A cylinder or a cone along z."""
    top = radius if top_radius is None else top_radius
    return Manifold.cylinder(z[1] - z[0], radius, top, segments).translate([0, 0, z[0]])


def prism(outline: Points, z: Span) -> Solid:
    """A polygon (N, 2), counter-clockwise, extruded along z."""
    return Manifold.extrude(CrossSection([outline]), z[1] - z[0]).translate([0, 0, z[0]])


def chamfered(outline: Points, z: Span, chamfer: float) -> Solid:
    """A prism over a convex polygon (N, 2) with chamfered lower and upper edges."""
    inset = inset_polygon(outline, chamfer)
    return hull((inset, z[0]), (outline, z[0] + chamfer), (outline, z[1] - chamfer), (inset, z[1]))


def hull(*rings: tuple[Points, float | Points]) -> Solid:
    """The convex hull of polygons (N, 2), each at one height z or at a height a corner."""
    corners = [np.column_stack([ring, np.broadcast_to(z, len(ring))]) for ring, z in rings]
    return Manifold.hull_points(np.concatenate(corners))


def inset_polygon(outline: Points, distance: float) -> Points:
    """A convex, counter-clockwise polygon (N, 2) with each side moved inwards, corner by corner."""
    sides = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([-sides[:, 1], sides[:, 0]])
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    before = np.roll(normals, 1, axis=0)
    bisector = before + normals
    scale = distance / (1 + (before * normals).sum(axis=1, keepdims=True))
    inset: Points = outline + bisector * scale
    return inset


def rounded_polygon(outline: Points, radius: float, steps: int) -> Points:
    """A convex, counter-clockwise polygon (N, 2) with an arc of `steps` sides at each corner."""
    corners = []
    for corner, center in zip(outline, inset_polygon(outline, radius), strict=True):
        before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
        i = int(np.flatnonzero((outline == corner).all(axis=1))[0])
        first, last = (_normal_angle(a) for a in (corner - before[i], after[i] - corner))
        turn = (last - first) % (2 * math.pi)
        angles = first + turn * np.linspace(0, 1, steps + 1 if turn > 1e-6 else 1)
        corners.append(center + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    arcs: Points = np.concatenate(corners)
    return arcs


def _normal_angle(side: Points) -> float:
    """Direction of the outward normal of a counter-clockwise side, rad."""
    return math.atan2(-side[0], side[1])


def circle(radius: float, segments: int, center: tuple[float, float] = (0.0, 0.0)) -> Points:
    """(segments, 2) corners of a regular polygon, counter-clockwise, the first at angle 0."""
    angle = np.arange(segments) * (2 * math.pi / segments)
    corners: Points = np.column_stack([np.cos(angle), np.sin(angle)]) * radius + np.array(center)
    return corners


def thread(
    root_radius: float,
    crest_radius: float,
    lead: float,
    starts: int,
    z: Span,
    *,
    arc_points: int = 4,
    step_deg: float = 15.0,
) -> Solid:
    """A right-handed screw thread along z: trapezoid profile, an exact helix.

    Across its axis the thread is one closed curve, turned on along z (`lead` a turn); at z = 0 a
    crest stands at angle 0.

    Args:
        root_radius: between the ridges.
        crest_radius: at the ridges.
        lead: advance of one turn.
        starts: ridges around; the pitch is lead / starts.
        z: from, to.
        arc_points: corners along a crest and along a root.
        step_deg: largest turn from one section to the next.
    """
    crest, flank, steps = 0.26, 0.22, arc_points
    share, radius = [], []
    for fraction in np.linspace(-crest / 2, crest / 2, steps):
        share.append(fraction)
        radius.append(crest_radius)
    for fraction in np.linspace(crest / 2 + flank, 1 - crest / 2 - flank, steps):
        share.append(fraction)
        radius.append(root_radius)
    turns = np.add.outer(np.arange(starts), np.array(share)).ravel() / starts
    radii = np.tile(radius, starts)
    outline = np.column_stack([np.cos(2 * math.pi * turns), np.sin(2 * math.pi * turns)])
    length, twist_deg = z[1] - z[0], 360 * (z[1] - z[0]) / lead
    divisions = math.ceil(abs(twist_deg) / step_deg)
    section = CrossSection([outline * radii[:, None]]).rotate(360 * z[0] / lead)
    solid = Manifold.extrude(section, length, divisions, twist_deg)
    return solid.translate([0, 0, z[0]])


def union(solids: Sequence[Solid]) -> Solid:
    """All of them in one."""
    total = Manifold()
    for solid in solids:
        total = total + solid
    return total


def write_ply(solid: Solid, path: Path) -> None:
    """Writes a binary PLY; the same solid gives the same bytes."""
    path.write_bytes(ply_bytes(solid))


def ply_bytes(solid: Solid) -> bytes:
    """The solid as a binary PLY: single-precision vertices, triangles."""
    mesh = solid.simplify(_SMALLEST_EDGE_MM).to_mesh()
    surface = trimesh.Trimesh(
        vertices=np.asarray(mesh.vert_properties)[:, :3], faces=mesh.tri_verts, process=False
    )
    return bytes(trimesh.exchange.ply.export_ply(surface, vertex_normal=False))
