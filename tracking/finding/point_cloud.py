"""A depth image as points, in rows and columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Array

_NO_DEPTH = 65535


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Every so many-th pixel of a depth image.

    Attributes:
        camera: the depth camera with only these pixels.
        depth_m: (h, w) float64, 0 where nothing is measured.
        points_m: (h, w, 3) float64, frame of the depth camera; zero where nothing is measured.
    """

    camera: PinholeCamera
    depth_m: Array
    points_m: Array

    @property
    def measured(self) -> npt.NDArray[np.bool_]:
        """(h, w) where something is measured."""
        return self.depth_m > 0


def point_cloud(
    depth: npt.NDArray[np.uint16],
    camera: PinholeCamera,
    depth_scale_m: float,
    stride_px: int,
    farthest_m: float,
) -> PointCloud:
    """The points of a depth image.

    Args:
        depth: (H, W) in units of `depth_scale_m`, 0 and 65535 mean no depth.
        camera: that took it.
        depth_scale_m: metres of one unit.
        stride_px: every so many-th pixel is taken, in both directions.
        farthest_m: what is farther away counts as not measured.
    """
    first = stride_px // 2
    counts = depth[first::stride_px, first::stride_px]
    depth_m = np.where(counts == _NO_DEPTH, 0.0, counts * depth_scale_m)
    depth_m[depth_m > farthest_m] = 0.0
    height, width = depth_m.shape
    small = PinholeCamera(
        width=width,
        height=height,
        fx=camera.fx / stride_px,
        fy=camera.fy / stride_px,
        cx=(camera.cx - first) / stride_px,
        cy=(camera.cy - first) / stride_px,
    )
    v, u = np.mgrid[:height, :width]
    x = (u - small.cx) / small.fx * depth_m
    y = (v - small.cy) / small.fy * depth_m
    return PointCloud(small, depth_m, np.stack([x, y, depth_m], axis=-1))


def extent_m(points: Array) -> float:
    """About the largest distance between two points: over directions of three planes."""
    angles = np.linspace(0, np.pi, 12, endpoint=False)
    cosines, sines, zeros = np.cos(angles), np.sin(angles), np.zeros(12)
    directions = np.concatenate(
        [
            np.stack(rows, axis=1)
            for rows in (
                (cosines, sines, zeros),
                (zeros, cosines, sines),
                (sines, zeros, cosines),
            )
        ]
    )
    return float(np.ptp(points @ directions.T, axis=0).max())
