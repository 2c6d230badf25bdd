"""Where the network says that a part is, as a region of the depth image."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Array
from snapfit.tracking.finding.point_cloud import PointCloud

_FEWEST_POINTS = 12
# What may hide the rest of a part: how wide a strip outside an edge is looked at, as a share of
# the box, and which share of it must be filled by what is no farther than this behind.
_STRIP, _FILLED, _BEHIND_M = 0.15, 0.25, 0.02

Edges = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Region:
    """A box around a part, hidden or joined as it may be.

    Attributes:
        box_px: (4,) left, top, right, bottom in the image of the cloud's camera.
        score: of the network's class, 0 to 1.
        stands: (h, w) points of the cloud that rise above the plane, of the whole image.
        middle_z_m: median distance along z of what is measured inside and rises above the plane.
        open_edges: (4,) bool, left, top, right, bottom: the part may go on beyond it, hidden.
    """

    box_px: Array
    score: float
    stands: npt.NDArray[np.bool_]
    middle_z_m: float
    open_edges: Edges = field(default_factory=lambda: np.zeros(4, dtype=bool))

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

    def off_px(self, low: Array, high: Array) -> Array:
        """(N, 4) how far edges of boxes from low to high (N, 2) are off those of the region, px.

        At an open edge only a box that ends inside is off.
        """
        off = np.concatenate([self.box_px[:2] - low, high - self.box_px[2:]], axis=1)
        result: Array = np.where(self.open_edges, np.minimum(off, 0.0), off)
        return result


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

    def opened(self, region: Region) -> Region | None:
        """The region as the visible piece of a part, None if nothing around can hide the rest.

        Networks often put the box around what they see, and not around the whole part. So it may
        go on where something stands right outside of the box that is no farther away.
        """
        height, width = self._stands.shape
        left, top, right, bottom = np.rint(region.box_px).astype(int)
        across, down = (max(2, round(_STRIP * float(side))) for side in region.size_px)
        strips = (
            np.s_[max(top, 0) : bottom, max(left - across, 0) : max(left, 0)],
            np.s_[max(top - down, 0) : max(top, 0), max(left, 0) : right],
            np.s_[max(top, 0) : bottom, min(right, width) : right + across],
            np.s_[min(bottom, height) : bottom + down, max(left, 0) : right],
        )
        hides = self._stands & (self._cloud.depth_m < region.middle_z_m + _BEHIND_M)
        edges = np.array([hides[strip].size and hides[strip].mean() > _FILLED for strip in strips])
        return replace(region, open_edges=edges) if edges.any() else None
