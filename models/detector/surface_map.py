"""Which point of which part is seen in each cell of a view: an exercise for the training alone.

A part's few keypoints say little of how it lies before the network tells its faces apart. Asking
each cell for the place on the part that it shows teaches that much sooner (Wang et al.,
"Normalized Object Coordinate Space", CVPR 2019). The finished network does not have this head.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.detector.shapes import PartShape
from snapfit.models.detector.views import View
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.train_labels import Instance

CELL_PX = 8
NOTHING = -1

SurfaceMap = tuple[npt.NDArray[np.int64], npt.NDArray[np.float32]]


def surface_map(
    view: View,
    camera: PinholeCamera,
    seen: Sequence[tuple[Instance, PartShape, Pose]],
) -> SurfaceMap:
    """The parts in the cells of a view.

    Args:
        view: of an image.
        camera: that took the image.
        seen: parts, with their canonical poses in the camera as it is rolled.

    Returns:
        (h, w) int64 class number of the part in each cell, -1 where there is none, and
        (h, w, 3) float32 its place on the part, -1 to 1 of the part's radius about its middle.
    """
    cells = view.camera(camera).scaled(1 / CELL_PX)
    numbers = np.full((cells.height, cells.width), NOTHING, dtype=np.int64)
    places = np.zeros((cells.height, cells.width, 3), dtype=np.float32)
    if not seen:
        return numbers, places
    drawn = render(cells, [(shape.coarse, pose) for _, shape, pose in seen])
    for i, (instance, shape, pose) in enumerate(seen):
        rows, columns = np.nonzero(drawn.part_id == i + 1)
        if len(rows) == 0:
            continue
        is_seen = _mask(instance, view, camera)[rows, columns]
        rows, columns = rows[is_seen], columns[is_seen]
        z = drawn.depth[rows, columns].astype(np.float64)
        x, y = (columns - cells.cx) / cells.fx * z, (rows - cells.cy) / cells.fy * z
        points = pose.inverse().transform(np.column_stack([x, y, z]))
        numbers[rows, columns] = shape.number
        places[rows, columns] = (points - shape.coarse.center_m) / shape.coarse.radius_m
    return numbers, places


def _mask(instance: Instance, view: View, camera: PinholeCamera) -> npt.NDArray[np.bool_]:
    """(h, w) cells in whose middle the part is seen."""
    matrix = view.matrix / CELL_PX
    # From middles of pixels to middles of cells.
    matrix[:, 2] += matrix[:, :2] @ (0.5, 0.5) - 0.5
    size = view.width // CELL_PX, view.height // CELL_PX
    whole = instance.mask(camera).astype(np.uint8)
    return np.asarray(cv2.warpAffine(whole, matrix, size, flags=cv2.INTER_NEAREST)) > 0
