"""Viewpoints on a geodesic grid: an icosahedron whose triangles are split in four, repeatedly."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose

N_DIVISIONS = 4


def geodesic_grid(
    n_divisions: int = N_DIVISIONS,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int16]]:
    """Directions spread evenly over the sphere.

    Args:
        n_divisions: how often each triangle is split in four; 4 gives 2562 directions.

    Returns:
        Directions (10 * 4**n + 2, 3), unit, and the neighbours (N, 6) of each; the twelve
        corners of the icosahedron have five and name themselves as the sixth.
    """
    vertices, faces = _icosahedron()
    for _ in range(n_divisions):
        vertices, faces = _split(vertices, faces)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    neighbours = np.repeat(np.arange(len(vertices), dtype=np.int16)[:, None], 6, axis=1)
    counts = np.zeros(len(vertices), dtype=np.int64)
    for a, b in [*edges.tolist(), *edges[:, ::-1].tolist()]:
        neighbours[a, counts[a]] = b
        counts[a] += 1
    return vertices, neighbours


def viewpoint_pose(
    direction: npt.NDArray[np.floating], center_m: npt.NDArray[np.float64], radius_m: float
) -> Pose:
    """`camera_from_body` of the camera at `center_m + radius_m * direction` facing the centre."""
    z = -np.asarray(direction, dtype=np.float64)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    return Pose.from_rotation_translation(rotation, -rotation @ (center_m - radius_m * z))


def _icosahedron() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    ratio = (1 + np.sqrt(5)) / 2
    corners = [
        np.roll((0.0, one, other), axis)
        for axis in range(3)
        for one in (-1.0, 1.0)
        for other in (-ratio, ratio)
    ]
    vertices = np.array(corners) / np.sqrt(1 + ratio**2)
    # Faces are the triples of corners that are one edge apart from each other.
    apart = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    near = (apart > 0) & (apart < 1.1 * apart[apart > 0].min())
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    return vertices, np.array(faces)


def _split(
    vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, middle = np.unique(sides, axis=0, return_inverse=True)
    middles = vertices[edges].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (len(vertices) + middle.reshape(-1, 3)).T
    a, b, c = faces.T
    quarters = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return (
        np.concatenate([vertices, middles]),
        np.concatenate([np.stack(corners, axis=1) for corners in quarters]),
    )
