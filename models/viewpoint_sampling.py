"""Numba kernels that choose a view's contour and surface points and describe each one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from snapfit.models.viewpoint_contour import Crossings

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]
Shorts = npt.NDArray[np.int16]

_LARGEST = 32767
_GOLDEN = 0.6180339887498949
# Powers of the plastic number: the golden section's counterpart in two dimensions.
_PLASTIC_U = 0.7548776662466927
_PLASTIC_V = 0.5698402909980532
_NORMAL_REACH_PX = 2.5
_STRAIGHT_SHARE = 0.92
_TRIES_PER_POINT = 64


class View(NamedTuple):
    """One rendered view.

    Attributes:
        pose: (4, 4) camera_from_body.
        camera: (4,) fx, fy, cx, cy in px.
        labels: (H, W) int32, 0 or the number + 1 of the visible face.
        inverse_depth: (H, W) 1/m.
        cells: (h, w) 1/m, the largest inverse depth in each cell of `cell_px` by `cell_px`.
        cell_px: width of a cell.
        window: rows from, to and columns from, to (exclusive) that hold the silhouette.
        occlusion_radius_m: how far around a point its depth offset is looked for.
        unit_m: of what is written.
    """

    pose: Floats
    camera: Floats
    labels: Ints
    inverse_depth: Singles
    cells: Singles
    cell_px: int
    window: tuple[int, int, int, int]
    occlusion_radius_m: float
    unit_m: float


@numba.njit(nogil=True, cache=True)
def nearest_of_cells(
    inverse_depth: Singles, window: tuple[int, int, int, int], cell_px: int, cells: Singles
) -> int:
    """Fill `cells` with the largest inverse depths, and count the pixels of the silhouette."""
    cells.fill(0)
    n_pixels = 0
    for row in range(window[0], window[1]):
        for column in range(window[2], window[3]):
            value = inverse_depth[row, column]
            if value > 0:
                n_pixels += 1
                i, j = row // cell_px, column // cell_px
                cells[i, j] = max(cells[i, j], value)
    return n_pixels


@numba.njit(nogil=True, cache=True)
def fill_contour(view: View, crossings: Crossings, rows: Shorts) -> float:
    """Fill the contour points (P, 9) of a view, evenly along the contours; their length in m."""
    n = crossings.used[1]
    if n == 0:
        return 0.0
    total = float(crossings.length[n])
    metres_px = 0.0
    place = 0.0
    tries = 0
    normal = np.zeros(2)
    for i in range(len(rows)):
        while True:
            place = (place + _GOLDEN) % 1.0
            k = _last_before(crossings.length, n, place * total)
            straight = _outward_normal(crossings, k, normal)
            tries += 1
            # At a sharp corner no direction is normal: draw another point, within reason.
            if straight > _STRAIGHT_SHARE or tries > _TRIES_PER_POINT * len(rows):
                break
        j = crossings.order[k]
        point, pixel = crossings.point[j], crossings.pixel[j]
        _write_position(view, point, rows[i])
        for axis in range(3):
            turned = normal[0] * view.pose[0, axis] + normal[1] * view.pose[1, axis]
            rows[i, 3 + axis] = round(turned * _LARGEST)
        metre_px = point[2] / view.camera[0]
        metres_px += metre_px
        for side in range(2):
            distance_m = _continuous_px(view.labels, pixel, normal, side) * metre_px
            rows[i, 6 + side] = _count(distance_m, view.unit_m)
        rows[i, 8] = _depth_offset(view, pixel[0], pixel[1], point[2])
    return total * metres_px / len(rows)


@numba.njit(nogil=True, cache=True)
def fill_surface(view: View, normals: Singles, rows: Shorts) -> None:
    """Fill the surface points (P, 7) of a view, evenly over the silhouette in the image.

    Args:
        view: with at least one pixel of silhouette.
        normals: (F, 3) unit, body frame, of either side.
        rows: what is filled.
    """
    top, bottom, left, right = view.window
    point = np.empty(3)
    a, b = 0.5, 0.5
    for i in range(len(rows)):
        while True:
            a, b = (a + _PLASTIC_U) % 1.0, (b + _PLASTIC_V) % 1.0
            row, column = int(top + a * (bottom - top)), int(left + b * (right - left))
            face = view.labels[row, column] - 1
            if face >= 0:
                break
        z = 1.0 / np.float64(view.inverse_depth[row, column])
        point[0] = (column - view.camera[2]) / view.camera[0] * z
        point[1] = (row - view.camera[3]) / view.camera[1] * z
        point[2] = z
        _write_position(view, point, rows[i])
        facing = 0.0
        for axis in range(3):
            for k in range(3):
                facing += point[k] * view.pose[k, axis] * normals[face, axis]
        side = -_LARGEST if facing > 0 else _LARGEST
        for axis in range(3):
            rows[i, 3 + axis] = round(normals[face, axis] * side)
        rows[i, 6] = _depth_offset(view, float(column), float(row), z)


@numba.njit(nogil=True, cache=True)
def _last_before(lengths: Floats, n: int, length: float) -> int:
    """The last of the first n ascending lengths that is not above `length` (0 if all are)."""
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if lengths[middle] <= length:
            low = middle
        else:
            high = middle
    return low


@numba.njit(nogil=True, cache=True)
def _outward_normal(crossings: Crossings, k: int, normal: Floats) -> float:
    """The normal at the k-th ordered crossing; the contour's chord there as a share of its arc."""
    first, end = crossings.loop[k, 0], crossings.loop[k, 1]
    ends = np.empty((2, 2))
    whole = 0.0
    for side in range(2):
        arc = 0.0
        at = k
        u, v = crossings.pixel[crossings.order[k], 0], crossings.pixel[crossings.order[k], 1]
        while arc < _NORMAL_REACH_PX:
            at += 1 if side == 1 else -1
            if at == end:
                at = first
            elif at < first:
                at = end - 1
            after = crossings.pixel[crossings.order[at]]
            arc += math.hypot(after[0] - u, after[1] - v)
            u, v = after[0], after[1]
        ends[side, 0], ends[side, 1] = u, v
        whole += arc
    along_u, along_v = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    chord = math.hypot(along_u, along_v)
    if chord == 0.0:
        normal[0], normal[1] = 1.0, 0.0
        return 0.0
    normal[0], normal[1] = along_v / chord, -along_u / chord
    return chord / whole


@numba.njit(nogil=True, cache=True)
def _continuous_px(labels: Ints, pixel: Floats, normal: Floats, side: int) -> float:
    """How far the silhouette reaches inwards (side 0), the background outwards (side 1), px."""
    height, width = labels.shape
    inside = side == 0
    du, dv = (2 * side - 1) * normal[0], (2 * side - 1) * normal[1]
    reach = 1.0
    while True:
        column, row = round(pixel[0] + reach * du), round(pixel[1] + reach * dv)
        if column < 0 or row < 0 or column >= width or row >= height:
            return math.inf
        if (labels[row, column] > 0) != inside:
            break
        reach += 1.0
    low, high = reach - 1.0, reach
    for _ in range(4):
        middle = 0.5 * (low + high)
        column, row = round(pixel[0] + middle * du), round(pixel[1] + middle * dv)
        if (labels[row, column] > 0) != inside:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


@numba.njit(nogil=True, cache=True)
def _depth_offset(view: View, u: float, v: float, z: float) -> int:
    """How much nearer than z the body comes within the occlusion radius of a pixel, in units."""
    reach = view.occlusion_radius_m * view.camera[0] / (z * view.cell_px)
    row, column = (v + 0.5) / view.cell_px - 0.5, (u + 0.5) / view.cell_px - 0.5
    nearest = 0.0
    for i in range(max(math.ceil(row - reach), 0), min(int(row + reach) + 1, len(view.cells))):
        half = math.sqrt(max(reach * reach - (i - row) ** 2, 0.0))
        first = max(math.ceil(column - half), 0)
        end = min(int(column + half) + 1, view.cells.shape[1])
        for j in range(first, end):
            nearest = max(nearest, view.cells[i, j])
    if nearest == 0.0:
        return 0
    return int(_count(max(z - 1.0 / nearest, 0.0), view.unit_m))


@numba.njit(nogil=True, cache=True)
def _count(length_m: float, unit_m: float) -> int:
    """A length in units, at most 32767."""
    return int(min(length_m / unit_m + 0.5, _LARGEST))


@numba.njit(nogil=True, cache=True)
def _write_position(view: View, point: Floats, row: Shorts) -> None:
    """Write a point of the camera frame, m, into row[:3], body frame, units."""
    for axis in range(3):
        value = 0.0
        for k in range(3):
            value += (point[k] - view.pose[k, 3]) * view.pose[k, axis]
        row[axis] = round(value / view.unit_m)
