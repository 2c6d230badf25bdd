"""How much parts go through each other or through the bench, to choose ways that do not."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping

import numpy as np
from manifold3d import Manifold
from manifold3d import Mesh as ManifoldMesh

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose

_MM = 1000.0
# Touching counts as apart: this much of a part's volume, this deep in the bench (mm).
_TOUCH_SHARE, _TOUCH_MM = 0.01, 2.0
_BENCH_WEIGHT = 0.05


class Clearance:
    """Closed meshes by part, to be intersected.

    Args:
        meshes: by part, closed.
        outer: (N, 3) corners of each part's convex hull.
    """

    def __init__(self, meshes: Mapping[str, Mesh], outer: Mapping[str, Array]) -> None:
        self._solids, self._volumes = {}, {}
        self._corners = {name: points * _MM for name, points in outer.items()}
        for name, mesh in meshes.items():
            points = np.asarray(mesh.vertices * _MM, dtype=np.float32)
            solid = Manifold(ManifoldMesh(points, mesh.faces.astype(np.uint32)))
            self._solids[name], self._volumes[name] = solid, max(float(solid.volume()), 1e-6)

    def overlap(self, moving: Mapping[str, Pose], standing: Mapping[str, Pose]) -> float:
        """How deep some parts are in others and in the bench (z = 0); 0 is clear.

        Args:
            moving: `world_from_part` of parts that move as one.
            standing: `world_from_part` of the others.

        Returns:
            Shares of the smaller part's volume, summed, and 0.05 for each millimetre of depth.
        """
        return self._overlap(moving, standing, self._boxes(standing))

    def _overlap(
        self, moving: Mapping[str, Pose], standing: Mapping[str, Pose], around: Mapping[str, Array]
    ) -> float:
        total = 0.0
        boxes = {**around, **self._boxes(moving)}
        for name in moving:
            depth_mm = -float(boxes[name][0, 2])
            total += _BENCH_WEIGHT * depth_mm if depth_mm > _TOUCH_MM else 0.0
        for a, b in itertools.product(moving, standing):
            if (boxes[a][1] < boxes[b][0]).any() or (boxes[b][1] < boxes[a][0]).any():
                continue
            between = standing[b].inverse() @ moving[a]
            common = float((_placed(self._solids[a], between) ^ self._solids[b]).volume())
            share = common / min(self._volumes[a], self._volumes[b])
            total += share if share > _TOUCH_SHARE else 0.0
        return total

    def gap_m(
        self, moving: Mapping[str, Pose], standing: Mapping[str, Pose], within_m: float
    ) -> float:
        """The least distance between surfaces of parts; 0 where they overlap.

        Args:
            moving: `world_from_part` of some parts.
            standing: `world_from_part` of the others.
            within_m: farther away is told as this.
        """
        least_mm = within_m * _MM
        boxes = self._boxes({**standing, **moving})
        for a, b in itertools.product(moving, standing):
            apart_mm = np.maximum(boxes[a][0] - boxes[b][1], boxes[b][0] - boxes[a][1])
            if float(np.linalg.norm(np.maximum(apart_mm, 0))) >= least_mm:
                continue
            between = standing[b].inverse() @ moving[a]
            placed = _placed(self._solids[a], between)
            least_mm = min(least_mm, float(placed.min_gap(self._solids[b], least_mm)))
        return least_mm / _MM

    def common_share(self, part: str, moved: Pose) -> float:
        """Share of a part's volume in which it is again after a motion of its own frame."""
        solid = self._solids[part]
        return float((_placed(solid, moved) ^ solid).volume()) / self._volumes[part]

    def worst(
        self, ways: Iterable[Pose], joined: Mapping[str, Pose], standing: Mapping[str, Pose]
    ) -> float:
        """The largest `overlap` on the way.

        Args:
            ways: `world_from_part` of the part that is moved.
            joined: `part_from_other` of it and all that moves with it.
            standing: `world_from_part` of the others.
        """
        around = self._boxes(standing)
        return max(
            self._overlap({name: way @ pose for name, pose in joined.items()}, standing, around)
            for way in ways
        )

    def _boxes(self, poses: Mapping[str, Pose]) -> dict[str, Array]:
        return {name: self._box(name, pose) for name, pose in poses.items()}

    def _box(self, name: str, pose: Pose) -> Array:
        """(2, 3) lowest and highest corner, world frame, mm."""
        points = self._corners[name] @ pose.rotation.T + pose.translation * _MM
        return np.stack([points.min(axis=0), points.max(axis=0)])


def _placed(solid: Manifold, pose: Pose) -> Manifold:
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= _MM
    return solid.transform(matrix)
