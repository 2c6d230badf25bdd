"""Which point of which part is seen in each cell of a view: an exercise for the training alone.

A part's few keypoints say little of how it lies before the network tells its faces apart. Asking
each cell for the place on the part that it shows teaches that much sooner (Wang et al.,
"Normalized Object Coordinate Space", CVPR 2019). The finished network does not have this head.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.detector.shapes import PartShape
from snapfit.models.detector.views import View
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.rle import is_in_mask, run_ends
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
        is_seen = _is_seen(instance, view, camera, rows, columns)
        rows, columns = rows[is_seen], columns[is_seen]
        z = drawn.depth[rows, columns].astype(np.float64)
        x, y = (columns - cells.cx) / cells.fx * z, (rows - cells.cy) / cells.fy * z
        points = pose.inverse().transform(np.column_stack([x, y, z]))
        numbers[rows, columns] = shape.number
        places[rows, columns] = (points - shape.coarse.center_m) / shape.coarse.radius_m
    return numbers, places


def _is_seen(
    instance: Instance,
    view: View,
    camera: PinholeCamera,
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
) -> npt.NDArray[np.bool_]:
    """(N,) whether the part is seen in the middles of cells."""
    places = (np.column_stack([columns, rows]) + 0.5) * CELL_PX - view.matrix[:, 2]
    pixels = np.rint(places @ np.linalg.inv(view.matrix[:, :2]).T - 0.5).astype(np.int64)
    u, v = pixels.T
    is_inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    is_seen = np.zeros(len(rows), dtype=np.bool_)
    ends = _ends(instance.mask_text)
    is_seen[is_inside] = is_in_mask(ends, v[is_inside], u[is_inside], camera.height)
    return is_seen


@lru_cache(maxsize=200_000)
def _ends(text: str) -> npt.NDArray[np.int64]:
    """Every image is looked at many times."""
    return run_ends(text)
