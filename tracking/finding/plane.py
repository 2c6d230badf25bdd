"""The plane that things lie on, by RANSAC (Open3D)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.finding.parameters import CloudParameters
from snapfit.tracking.finding.point_cloud import PointCloud, extent_m

_SAMPLE = 8000
_FEWEST = 100
_OWN_HEIGHT = 0.4
_SEED = 0


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane, its normal turned to the camera.

    Attributes:
        normal: (3,) unit, frame of the points.
        offset_m: of the camera above the plane.
        deviation_m: standard deviation of the plane's own points, noise of the sensor.
    """

    normal: Array
    offset_m: float
    deviation_m: float

    def heights_m(self, points_m: Array) -> Array:
        """(...) how far points (..., 3) rise above the plane."""
        heights: Array = points_m @ self.normal + self.offset_m
        return heights


def find_plane(
    cloud: PointCloud, parameters: CloudParameters, least_extent_m: float
) -> Plane | None:
    """The largest plane; None where no plane holds enough of the points.

    Args:
        cloud: what is measured.
        parameters: of RANSAC.
        least_extent_m: what extends less is the face of a thing, not what it lies on.

    Raises:
        TrackingError: Open3D cannot be imported.
    """
    points = cloud.points_m[cloud.measured]
    if len(points) < _FEWEST:
        return None
    sample = points[:: max(len(points) // _SAMPLE, 1)]
    module = open3d()
    # RANSAC draws from Open3D's own generator: the same seed, the same plane.
    module.utility.random.seed(_SEED)
    wrapped = module.geometry.PointCloud(module.utility.Vector3dVector(sample))
    model, inliers = wrapped.segment_plane(parameters.plane_tolerance_m, 3, parameters.plane_rounds)
    on_plane = sample[inliers]
    if len(inliers) < parameters.plane_share * len(sample) or extent_m(on_plane) < least_extent_m:
        return None
    normal, offset_m = np.array(model[:3]), float(model[3])
    if offset_m < 0:
        normal, offset_m = -normal, -offset_m
    # The tolerance takes in the lowest of the things: the median of the deviations does not mind.
    heights = on_plane @ normal + offset_m
    deviation_m = 1.4826 * float(np.median(np.abs(heights - np.median(heights))))
    return Plane(normal, offset_m - float(np.median(heights)), deviation_m)


def rises(
    cloud: PointCloud, plane: Plane | None, parameters: CloudParameters
) -> npt.NDArray[np.bool_]:
    """(h, w) where something stands or lies on the plane; without a plane all that is measured.

    Heights are averaged over 3 x 3 points, so that a plate of few millimetres stands out.
    """
    if plane is None:
        return cloud.measured
    heights = np.where(cloud.measured, plane.heights_m(cloud.points_m), 0.0)
    # Noise is averaged, steps are not: a point counts by its own height, where that is clear.
    low = np.clip(heights, -parameters.plane_tolerance_m, 2 * parameters.plane_tolerance_m)
    weights = cv2.blur(cloud.measured.astype(np.float64), (3, 3))
    smooth = cv2.blur(np.where(cloud.measured, low, 0.0), (3, 3)) / np.maximum(weights, 1e-6)
    least_m = max(parameters.least_rise_m, parameters.rise_deviations * plane.deviation_m / 3)
    stands: npt.NDArray[np.bool_] = smooth > least_m
    return cloud.measured & stands & (heights > _OWN_HEIGHT * least_m)
