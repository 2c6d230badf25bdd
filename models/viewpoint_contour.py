"""Numba kernels that find the outline of a body in a view, exact to far below a pixel.

The silhouette of a polyhedron is made of edges between a face that looks at the camera and one that
looks away. A *crossing* is where such an edge passes between a pixel centre in the silhouette and a
neighbour outside: its place in the image and in space is exact. Crossings are put in order by
walking along the border between silhouette and background with the silhouette on one side.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

_SAME_PIXEL_PX = 1e-6
_SHORTEST_CONTOUR_PX = 12.0


class Crossings(NamedTuple):
    """Room for the crossings of one view; `used[0]` are in use, in order `order[:used[1]]`.

    Attributes:
        number: (2, H, W) int32, number + 1 of the crossing between a pixel and the next one in
            its row (0) or column (1).
        place: (N, 3) int32, where in `number` a crossing stands.
        pixel: (N, 2) u, v in px.
        point: (N, 3) m, camera frame.
        order: (N,) int32, crossings along the contours, one contour after the other.
        loop: (N, 2) int32, from and to (exclusive) in `order` of the contour it belongs to.
        length: (N + 1,) px, length of the contours before each crossing in `order`.
        used: (2,) int64.
    """

    number: Ints
    place: Ints
    pixel: Floats
    point: Floats
    order: Ints
    loop: Ints
    length: Floats
    used: npt.NDArray[np.int64]


def make_crossings(size: int) -> Crossings:
    """Room for a view of `size` by `size` pixels."""
    n = 64 * size
    return Crossings(
        number=np.zeros((2, size, size), dtype=np.int32),
        place=np.zeros((n, 3), dtype=np.int32),
        pixel=np.zeros((n, 2)),
        point=np.zeros((n, 3)),
        order=np.zeros(n, dtype=np.int32),
        loop=np.zeros((n, 2), dtype=np.int32),
        length=np.zeros(n + 1),
        used=np.zeros(2, dtype=np.int64),
    )


@numba.njit(nogil=True, cache=True)
def clear_crossings(crossings: Crossings) -> None:
    """Forget the crossings of the last view."""
    for i in range(crossings.used[0]):
        place = crossings.place[i]
        crossings.number[place[0], place[1], place[2]] = 0
    crossings.used.fill(0)


@numba.njit(nogil=True, cache=True)
def find_crossings(
    points: Floats,
    projected: Floats,
    faces: Ints,
    edges: Ints,
    labels: Ints,
    crossings: Crossings,
) -> None:
    """All crossings of silhouette edges with the border of the silhouette.

    Args:
        points: (V, 3) m, camera frame.
        projected: (V, 3) u, v in px and 1/z.
        faces: (F, 3).
        edges: (E, 5) two vertices, two faces (-1: none), and 1 where the two faces run through
            the edge in one direction (so that one of them is turned inside out).
        labels: (H, W), 0 outside the silhouette.
        crossings: what is filled.
    """
    front = np.empty(len(faces), dtype=np.bool_)
    for f in range(len(faces)):
        p, q, r = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        volume = (
            p[0] * (q[1] * r[2] - q[2] * r[1])
            + p[1] * (q[2] * r[0] - q[0] * r[2])
            + p[2] * (q[0] * r[1] - q[1] * r[0])
        )
        front[f] = volume < 0
    for e in range(len(edges)):
        if edges[e, 3] >= 0:
            differ = front[edges[e, 2]] != front[edges[e, 3]]
            if differ == (edges[e, 4] == 1):
                continue
        for kind in range(2):
            _cross_lines(points, projected, edges[e, 0], edges[e, 1], kind, labels, crossings)


@numba.njit(nogil=True, cache=True)
def _cross_lines(
    points: Floats,
    projected: Floats,
    a: int,
    b: int,
    kind: int,
    labels: Ints,
    crossings: Crossings,
) -> None:
    """Cut the edge from vertex a to b with all pixel rows (kind 0) or columns (kind 1)."""
    across, along = 1 - kind, kind
    if projected[a, across] > projected[b, across]:
        a, b = b, a
    span = projected[b, across] - projected[a, across]
    if span <= 0:
        return
    step = (projected[b, along] - projected[a, along]) / span
    first = max(math.ceil(projected[a, across]), 0)
    last = min(math.floor(projected[b, across]), labels.shape[kind] - 1)
    for line in range(first, last + 1):
        beyond = line - projected[a, across]
        position = projected[a, along] + beyond * step
        share = beyond / span * projected[b, 2]
        share /= share + (1 - beyond / span) * projected[a, 2]
        cell = math.floor(position)
        _offer(points, a, b, share, kind, line, cell, position, labels, crossings)
        # A border that runs through a pixel centre may belong to the pair on either side.
        if position - cell < _SAME_PIXEL_PX:
            _offer(points, a, b, share, kind, line, cell - 1, position, labels, crossings)
        elif position - cell > 1 - _SAME_PIXEL_PX:
            _offer(points, a, b, share, kind, line, cell + 1, position, labels, crossings)


@numba.njit(nogil=True, cache=True)
def _offer(
    points: Floats,
    a: int,
    b: int,
    share: float,
    kind: int,
    line: int,
    cell: int,
    position: float,
    labels: Ints,
    crossings: Crossings,
) -> None:
    """Keep a cut if it lies on the border of the silhouette, the outermost of a pair of pixels."""
    if cell < 0 or cell > labels.shape[1 - kind] - 2:
        return
    row, column = (line, cell) if kind == 0 else (cell, line)
    here = labels[row, column] > 0
    there = (labels[row, column + 1] if kind == 0 else labels[row + 1, column]) > 0
    if here == there:
        return
    i = crossings.number[kind, row, column] - 1
    if i >= 0:
        known = crossings.pixel[i, kind]
        if (here and position <= known) or (there and position >= known):
            return
    else:
        i = _new_crossing(kind, row, column, crossings)
        if i < 0:
            return
    crossings.pixel[i, kind] = position
    crossings.pixel[i, 1 - kind] = line
    for axis in range(3):
        crossings.point[i, axis] = points[a, axis] + share * (points[b, axis] - points[a, axis])


@numba.njit(nogil=True, cache=True)
def _new_crossing(kind: int, row: int, column: int, crossings: Crossings) -> int:
    i = int(crossings.used[0])
    if i == len(crossings.place):
        return -1
    crossings.used[0] += 1
    crossings.number[kind, row, column] = i + 1
    crossings.place[i, 0], crossings.place[i, 1], crossings.place[i, 2] = kind, row, column
    return i


@numba.njit(nogil=True, cache=True)
def follow_contours(
    labels: Ints, inverse_depth: npt.NDArray[np.float32], camera: Floats, crossings: Crossings
) -> None:
    """Order the crossings along the contours, the silhouette at one hand; drop tiny contours.

    Args:
        labels: (H, W), 0 outside the silhouette.
        inverse_depth: (H, W) 1/m.
        camera: (4,) fx, fy, cx, cy in px.
        crossings: what is ordered; one that no edge gave is put in the middle of its pixels.
    """
    seen = np.zeros(len(crossings.place), dtype=np.bool_)
    # Typed, because Numba compiles the callee once more for a literal.
    start, n = np.int64(0), np.int64(0)
    while start < crossings.used[0]:
        first, i = n, start
        while i >= 0 and not seen[i]:
            seen[i] = True
            crossings.order[n] = i
            n += 1
            i = _next_crossing(i, labels, inverse_depth, camera, crossings)
        for k in range(first, n):
            here = crossings.pixel[crossings.order[k]]
            after = crossings.pixel[crossings.order[k + 1 if k + 1 < n else first]]
            step = math.hypot(after[0] - here[0], after[1] - here[1])
            crossings.length[k + 1] = crossings.length[k] + step
            crossings.loop[k, 0], crossings.loop[k, 1] = first, n
        if crossings.length[n] - crossings.length[first] < _SHORTEST_CONTOUR_PX:
            n = first
        start += 1
    crossings.used[1] = n


@numba.njit(nogil=True, cache=True)
def _next_crossing(
    i: int,
    labels: Ints,
    inverse_depth: npt.NDArray[np.float32],
    camera: Floats,
    crossings: Crossings,
) -> int:
    """The crossing that follows on i, made if no edge gave it; -1 where the room is used up."""
    kind, row, column = crossings.place[i, 0], crossings.place[i, 1], crossings.place[i, 2]
    in_row, in_column, out_row, out_column = row, column, row + kind, column + 1 - kind
    if labels[row, column] == 0:
        in_row, in_column, out_row, out_column = out_row, out_column, in_row, in_column
    down, right = out_column - in_column, in_row - out_row
    if labels[in_row + down, in_column + right] == 0:
        out_row, out_column = in_row + down, in_column + right
    elif labels[out_row + down, out_column + right] == 0:
        in_row, in_column = in_row + down, in_column + right
        out_row, out_column = out_row + down, out_column + right
    else:
        in_row, in_column = out_row + down, out_column + right
    kind = 0 if in_row == out_row else 1
    row, column = min(in_row, out_row), min(in_column, out_column)
    found = int(crossings.number[kind, row, column]) - 1
    if found >= 0:
        return found
    found = int(_new_crossing(kind, row, column, crossings))
    if found >= 0:
        u, v = 0.5 * (in_column + out_column), 0.5 * (in_row + out_row)
        z = 1.0 / inverse_depth[in_row, in_column]
        crossings.pixel[found, 0], crossings.pixel[found, 1] = u, v
        crossings.point[found, 0] = (u - camera[2]) / camera[0] * z
        crossings.point[found, 1] = (v - camera[3]) / camera[1] * z
        crossings.point[found, 2] = z
    return found
