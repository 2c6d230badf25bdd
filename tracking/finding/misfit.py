"""How badly many poses at once fit a cluster: surface, contour, area, and the plane below."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array
from snapfit.tracking.finding.clusters import Cluster
from snapfit.tracking.finding.parameters import ProposalParameters
from snapfit.tracking.finding.plane import Plane
from snapfit.tracking.finding.point_cloud import PointCloud

Points = npt.NDArray[np.floating[Any]]

_AREA_WEIGHT_M = 0.01
_HOVERING_WEIGHT = 0.2


class Misfit:
    """Judges poses by points of the part, given about the cluster's middle, depth camera's frame.

    Args:
        cloud: what is measured.
        plane: that the part may lie on, but not in; None where there is none.
        cluster: that is to be explained.
        parameters: of the proposals.
    """

    def __init__(
        self,
        cloud: PointCloud,
        plane: Plane | None,
        cluster: Cluster,
        parameters: ProposalParameters,
    ) -> None:
        self._camera = cloud.camera
        self._plane = plane
        self._cluster = cluster
        self._reach_m = np.float32(parameters.reach_m)
        self._middle_m = cluster.middle_m.astype(np.float32)
        height, width = cluster.mask.shape
        window = np.s_[cluster.top : cluster.top + height, cluster.left : cluster.left + width]
        depth_m = cloud.depth_m[window].astype(np.float32)
        # Nothing is wrong where the cluster has a hole in the depth, all where it is not.
        self._depth_m = np.where(cluster.mask, np.where(depth_m > 0, depth_m, np.nan), np.inf)
        self._outline_m = cluster.outline * np.float32(cluster.middle_m[2] / cloud.camera.fx)

    def of_surface(self, points: Points) -> Array:
        """(N,) m, mean distance along z between points (N, P, 3) and what is measured there."""
        rows, columns, z = self._pixels(points)
        errors = np.abs(self._depth_m[rows, columns] - z)
        return self._mean(np.where(np.isnan(errors), np.float32(0), errors))

    def of_contour(self, points: Points) -> Array:
        """(N,) m, mean distance of contour points (N, P, 3) from the cluster's outline."""
        rows, columns, _ = self._pixels(points)
        return self._mean(self._outline_m[rows, columns])

    def of_area(self, areas_m2: Array) -> Array:
        """(N,) m for the areas (N,) of the views."""
        ratios: Array = np.abs(np.log(areas_m2 / self._cluster.area_m2))
        return _AREA_WEIGHT_M * ratios

    def of_support(self, corners: Array) -> Array:
        """(N,) m that poses lie in the plane, or with less weight above it; corners (N, C, 3)."""
        if self._plane is None:
            return np.zeros(len(corners))
        lowest_m = self._plane.heights_m(corners + self._cluster.middle_m).min(axis=1)
        below_m = np.clip(-lowest_m, 0, self._reach_m)
        above_m = np.clip(lowest_m, 0, self._reach_m)
        result: Array = below_m + _HOVERING_WEIGHT * above_m
        return result

    def _mean(self, errors: npt.NDArray[np.float32]) -> Array:
        mean: Array = np.minimum(errors, self._reach_m).mean(axis=-1).astype(np.float64)
        return mean

    def _pixels(
        self, points: Points
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Points]:
        """Rows and columns (N, P) in the cluster's window, and z; at its border what is outside."""
        cluster, camera = self._cluster, self._camera
        height, width = cluster.mask.shape
        z = points[..., 2] + self._middle_m[2]
        u = (points[..., 0] + self._middle_m[0]) * np.float32(camera.fx) / z
        v = (points[..., 1] + self._middle_m[1]) * np.float32(camera.fy) / z
        columns = np.rint(u + np.float32(camera.cx - cluster.left)).astype(np.int64)
        rows = np.rint(v + np.float32(camera.cy - cluster.top)).astype(np.int64)
        return np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1), z
