"""Where the colours of a part are seen and no other part explains them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Array
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Optimiser

_GRID_PX = 8
_FOREGROUND = 0.65
_BLOBS_MAX = 3
_LEAST_CELLS = 4
_LONG = 0.5


@dataclass(frozen=True, eq=False)
class Place:
    """Where colours of a body are seen.

    Attributes:
        middle: (3,) m, camera frame.
        direction_rad: in which it is long, from the image's x axis; None if in no one.
    """

    middle: Array
    direction_rad: float | None


class PlaceFinder:
    """Finds places in the frames of one camera.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        optimiser: that has learned the bodies' colours.
    """

    def __init__(self, bodies: Sequence[Body], camera: RgbdCamera, optimiser: Optimiser) -> None:
        self._camera, self._optimiser = camera, optimiser
        self._radii = [float(body.mesh.radius_m) for body in bodies]

    def find(self, frame: Frame, body: int) -> list[Place]:
        """Where the body may be, by its colours; the largest first."""
        color, depth = self._camera.color, self._camera.depth
        if depth is None or frame.depth is None:
            return []
        first = _GRID_PX // 2
        bins = frame.color[first::_GRID_PX, first::_GRID_PX].astype(np.int64) >> 4
        likely = self._optimiser.tables[body][bins @ np.array([256, 16, 1])] > _FOREGROUND
        near = self._optimiser.nearby_id
        rows, columns = (
            np.minimum((np.arange(n) * _GRID_PX + first) * size // whole, size - 1)
            for n, size, whole in zip(
                likely.shape, near.shape, (color.height, color.width), strict=True
            )
        )
        others = near[np.ix_(rows, columns)]
        likely &= (others == 0) | (others == body + 1)
        places = []
        for row, column, direction_rad in _blobs(likely):
            u, v = (column + 0.5) * _GRID_PX, (row + 0.5) * _GRID_PX
            z = self._depth_at(depth, frame.depth, u, v)
            if z > 0:
                ray = np.array([(u - color.cx) / color.fx, (v - color.cy) / color.fy, 1.0])
                places.append(Place(ray * (z + 0.3 * self._radii[body]), direction_rad))
        return places

    def _depth_at(
        self, camera: PinholeCamera, depth: npt.NDArray[np.uint16], u: float, v: float
    ) -> float:
        """Median depth around a place of the colour image, m; 0 where nothing is measured.

        The shift between the two cameras is left out: this is where a search begins.
        """
        color = self._camera.color
        column = int((u - color.cx) / color.fx * camera.fx + camera.cx)
        row = int((v - color.cy) / color.fy * camera.fy + camera.cy)
        window = depth[max(row - 6, 0) : row + 7 : 2, max(column - 6, 0) : column + 7 : 2]
        known = window[(window > 0) & (window < 65535)]
        return float(np.median(known)) * self._camera.depth_scale_m if known.size else 0.0


def _blobs(likely: npt.NDArray[np.bool_]) -> list[tuple[float, float, float | None]]:
    """Middle (row, column) and direction (rad) of the largest connected regions."""
    n, labels, stats, centroids = cv2.connectedComponentsWithStats(likely.astype(np.uint8))
    sizes = stats[1:n, cv2.CC_STAT_AREA]
    blobs = []
    for i in np.argsort(-sizes)[:_BLOBS_MAX]:
        if sizes[i] >= _LEAST_CELLS:
            rows, columns = np.nonzero(labels == 1 + i)
            x, y = centroids[1 + i]
            blobs.append((float(y), float(x), _direction(rows - y, columns - x)))
    return blobs


def _direction(rows: Array, columns: Array) -> float | None:
    """Direction in which cells are spread, rad from the image's x axis; None if in all alike."""
    xx, yy, xy = float(columns @ columns), float(rows @ rows), float(rows @ columns)
    if np.hypot(xx - yy, 2 * xy) < _LONG * (xx + yy):
        return None
    return float(0.5 * np.arctan2(2 * xy, xx - yy))
