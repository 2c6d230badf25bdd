"""Where the network says that a part is, as a region of the depth image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Array
from snapfit.tracking.finding.point_cloud import PointCloud

_FEWEST_POINTS = 12


@dataclass(frozen=True, eq=False)
class Region:
    """A box around a whole part, hidden or joined as it may be.

    Attributes:
        box_px: (4,) left, top, right, bottom in the image of the cloud's camera.
        score: of the network's class, 0 to 1.
        stands: (h, w) points of the cloud that rise above the plane, of the whole image.
        middle_z_m: median distance along z of what is measured inside and rises above the plane.
    """

    box_px: Array
    score: float
    stands: npt.NDArray[np.bool_]
    middle_z_m: float

    @property
    def size_px(self) -> Array:
        """(2,) width and height."""
        size: Array = self.box_px[2:] - self.box_px[:2]
        return size

    @property
    def center_px(self) -> Array:
        """(2,) column and row of the box's middle."""
        center: Array = (self.box_px[:2] + self.box_px[2:]) / 2
        return center


class RegionMap:
    """Cuts regions of one frame.

    Args:
        cloud: what is measured.
        stands: (h, w) those of its points that rise above the plane.
        camera: both cameras, as they stand to one another.
    """

    def __init__(
        self, cloud: PointCloud, stands: npt.NDArray[np.bool_], camera: RgbdCamera
    ) -> None:
        self._cloud, self._camera, self._stands = cloud, camera, stands
        self._z_m = cloud.depth_m[stands]
        seen = camera.color_from_depth.transform(cloud.points_m[stands])
        self._pixels = camera.color.project(seen) if len(seen) else np.zeros((0, 2))

    def cut(self, box_px: Array, score: float) -> Region | None:
        """The region of a box in the colour image; None where too little is measured.

        Args:
            box_px: (4,) left, top, right, bottom, px of the colour image.
            score: of the network's class.
        """
        left, top, right, bottom = (float(each) for each in box_px)
        u, v = self._pixels.T
        inside = (u >= left) & (u <= right) & (v >= top) & (v <= bottom)
        if inside.sum() < _FEWEST_POINTS or right - left < 2 or bottom - top < 2:
            return None
        z_m = float(np.median(self._z_m[inside]))
        color = self._camera.color
        corners = [
            ((x - color.cx) / color.fx * z_m, (y - color.cy) / color.fy * z_m, z_m)
            for x in (left, right)
            for y in (top, bottom)
        ]
        depth_from_color = self._camera.color_from_depth.inverse()
        places = self._cloud.camera.project(depth_from_color.transform(np.array(corners)))
        box = np.concatenate([places.min(axis=0), places.max(axis=0)])
        return Region(box, score, self._stands, z_m)
