"""Whether two parts touch: the least distance between samples of their surfaces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array

_N_SAMPLES = 2500


class Contacts:
    """Surfaces of parts, ready to be asked for contact.

    Attributes:
        center_m: (3,) middle of each part's box, body frame.
        radius_m: of a sphere about it that holds the part.
        diameter_m: largest distance within each part.

    Args:
        parts: the tracked parts.
    """

    def __init__(self, parts: Iterable[Part]) -> None:
        parts = tuple(parts)
        samples = {part.name: surface_samples(part.mesh) for part in parts}
        self.center_m = {part.name: part.mesh.center_m.astype(np.float64) for part in parts}
        self.radius_m = {part.name: float(part.mesh.radius_m) for part in parts}
        self.diameter_m = {part.name: float(part.mesh.diameter_m) for part in parts}
        self._samples = samples
        self._trees = {name: cKDTree(points) for name, points in samples.items()}

    def gap_m(self, part_a: str, part_b: str, a_from_b: Array, within_m: float) -> float:
        """Distance between two surfaces at a relative pose (4, 4); infinite beyond a bound.

        It is measured between samples and is too large by up to half their distance, 1 to 2 mm.
        """
        moved = self._samples[part_b] @ a_from_b[:3, :3].T + a_from_b[:3, 3]
        away = np.linalg.norm(moved - self.center_m[part_a], axis=1)
        moved = moved[away < self.radius_m[part_a] + within_m]
        if not len(moved):
            return float("inf")
        distance, _ = self._trees[part_a].query(moved, distance_upper_bound=within_m)
        return float(distance.min())


def surface_samples(mesh: Mesh) -> Array:
    """(N, 3) points of a surface, evenly by area, and its vertices; always the same ones."""
    rng = np.random.default_rng(0)
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(*edges), axis=1)
    chosen = rng.choice(len(areas), _N_SAMPLES, p=areas / areas.sum())
    u, v = rng.random((2, _N_SAMPLES, 1))
    beyond = u + v > 1
    u, v = np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)
    inside = corners[chosen, 0] + u * edges[0][chosen] + v * edges[1][chosen]
    vertices = mesh.vertices.astype(np.float64)
    if len(vertices) > _N_SAMPLES:
        vertices = rng.choice(vertices, _N_SAMPLES, replace=False)
    return np.vstack([inside, vertices])
