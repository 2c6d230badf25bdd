"""Numba kernels of the z-buffer. All are compiled without the GIL and cached on disk.

While a picture is drawn its depth buffer holds inverse depths, 1/m: 0 is infinitely far, the larger
wins, and 1/z is what is linear in the image. `finish_depth` turns them into metres.
Pixel centres stand at integers; a pixel belongs to a triangle whose inside or border holds its
centre, and an edge is cut at the same place for both of its triangles, so that no gap opens.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

NEAR_M = 0.001
_SMALLEST_AREA_PX2 = 1e-9

Floats = npt.NDArray[np.float64]
Depth = npt.NDArray[np.float32]
Faces = npt.NDArray[np.int32]


@numba.njit(nogil=True, cache=True)
def to_camera(vertices: npt.NDArray[np.float32], camera_from_body: Floats) -> Floats:
    """Vertices (V, 3), m, body frame, to (V, 3), m, camera frame."""
    result = np.empty((len(vertices), 3))
    m = camera_from_body
    for i in range(len(vertices)):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        for row in range(3):
            result[i, row] = m[row, 0] * x + m[row, 1] * y + m[row, 2] * z + m[row, 3]
    return result


@numba.njit(nogil=True, cache=True)
def project(points: Floats, intrinsics: Floats) -> Floats:
    """Points (N, 3), m, camera frame, to (N, 3): u, v in px and 1/z; 1/z is 0 before `NEAR_M`."""
    result = np.zeros((len(points), 3))
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    for i in range(len(points)):
        if points[i, 2] >= NEAR_M:
            inverse = 1.0 / points[i, 2]
            result[i, 0] = fx * points[i, 0] * inverse + cx
            result[i, 1] = fy * points[i, 1] * inverse + cy
            result[i, 2] = inverse
    return result


@numba.njit(nogil=True, cache=True)
def fill_triangle(
    projected: Floats,
    a: int,
    b: int,
    c: int,
    label: int,
    inverse_depth: Depth,
    labels: npt.NDArray[np.integer],
) -> None:
    """Draw a triangle of projected corners where it is the nearest so far.

    Args:
        projected: (N, 3) u px, v px, 1/z.
        a: first corner, a row of `projected`.
        b: second corner.
        c: third corner.
        label: what is written into `labels` where the triangle wins.
        inverse_depth: (H, W) 1/m.
        labels: (H, W).
    """
    height, width = inverse_depth.shape
    if projected[a, 1] > projected[b, 1]:
        a, b = b, a
    if projected[b, 1] > projected[c, 1]:
        b, c = c, b
        if projected[a, 1] > projected[b, 1]:
            a, b = b, a
    au, av, aw = projected[a, 0], projected[a, 1], projected[a, 2]
    first_row = max(math.ceil(av), 0)
    last_row = min(math.floor(projected[c, 1]), height - 1)
    if first_row > last_row:
        return
    bu, bv, bw = projected[b, 0] - au, projected[b, 1] - av, projected[b, 2] - aw
    cu, cv, cw = projected[c, 0] - au, projected[c, 1] - av, projected[c, 2] - aw
    area = bu * cv - bv * cu
    if abs(area) < _SMALLEST_AREA_PX2:
        return
    slope_u = (bw * cv - cw * bv) / area
    slope_v = (cw * bu - bw * cu) / area
    long_step = cu / cv
    upper_step = bu / bv if bv > 0 else 0.0
    lower_step = 0.0
    if projected[c, 1] > projected[b, 1]:
        # From b itself, not from a: the same digits in the triangle beyond this edge.
        lower_step = (projected[c, 0] - projected[b, 0]) / (projected[c, 1] - projected[b, 1])
    for row in range(first_row, last_row + 1):
        below_a = row - av
        one = au + below_a * long_step
        two = au + below_a * upper_step
        if below_a >= bv:
            two = projected[b, 0] + (row - projected[b, 1]) * lower_step
        left, right = min(one, two), max(one, two)
        if right < 0 or left > width - 1:
            continue
        start = math.ceil(left) if left > 0 else 0
        stop = math.floor(right) if right < width - 1 else width - 1
        value = aw + (start - au) * slope_u + below_a * slope_v
        for column in range(start, stop + 1):
            nearness = np.float32(value)
            if nearness > inverse_depth[row, column]:
                inverse_depth[row, column] = nearness
                labels[row, column] = label
            value += slope_u


@numba.njit(nogil=True, cache=True)
def fill_clipped(
    corners: Floats,
    intrinsics: Floats,
    label: int,
    inverse_depth: Depth,
    labels: npt.NDArray[np.integer],
) -> None:
    """Draw what lies beyond the near plane of a triangle that crosses it.

    Args:
        corners: (3, 3) m, camera frame.
        intrinsics: (4,) fx, fy, cx, cy in px.
        label: as in `fill_triangle`.
        inverse_depth: (H, W) 1/m.
        labels: (H, W).
    """
    kept = np.zeros((4, 3))
    n = np.int64(0)
    for i in range(3):
        j = (i + 1) % 3
        z_i, z_j = corners[i, 2], corners[j, 2]
        if z_i >= NEAR_M:
            for axis in range(3):
                kept[n, axis] = corners[i, axis]
            n += 1
        if (z_i >= NEAR_M) != (z_j >= NEAR_M):
            share = (NEAR_M - z_i) / (z_j - z_i)
            for axis in range(2):
                kept[n, axis] = corners[i, axis] + share * (corners[j, axis] - corners[i, axis])
            kept[n, 2] = NEAR_M
            n += 1
    projected = project(kept, intrinsics)
    first = np.int64(0)  # typed, because Numba compiles the callee once more for a literal
    for i in range(2, n):
        fill_triangle(projected, first, i - 1, i, label, inverse_depth, labels)


@numba.njit(nogil=True, cache=True)
def fill_body(
    points: Floats,
    faces: Faces,
    intrinsics: Floats,
    first_label: int,
    label_step: int,
    inverse_depth: Depth,
    labels: npt.NDArray[np.integer],
) -> tuple[int, int, int, int]:
    """Draw all triangles of a body.

    Args:
        points: (V, 3) m, camera frame.
        faces: (F, 3).
        intrinsics: (4,) fx, fy, cx, cy in px.
        first_label: what face 0 writes into `labels`.
        label_step: face i writes first_label + i * label_step.
        inverse_depth: (H, W) 1/m.
        labels: (H, W) uint8 (a label a body) or int32 (a label a face).

    Returns:
        Rows from, to and columns from, to (exclusive) outside which nothing was drawn.
    """
    height, width = inverse_depth.shape
    projected = project(points, intrinsics)
    low_u, low_v, high_u, high_v = math.inf, math.inf, -math.inf, -math.inf
    for i in range(len(points)):
        if projected[i, 2] > 0:
            low_u, high_u = min(low_u, projected[i, 0]), max(high_u, projected[i, 0])
            low_v, high_v = min(low_v, projected[i, 1]), max(high_v, projected[i, 1])
    clipped = False
    for f in range(len(faces)):
        a, b, c = np.int64(faces[f, 0]), np.int64(faces[f, 1]), np.int64(faces[f, 2])
        label = first_label + f * label_step
        n_seen = (projected[a, 2] > 0) + (projected[b, 2] > 0) + (projected[c, 2] > 0)
        if n_seen == 3:
            fill_triangle(projected, a, b, c, label, inverse_depth, labels)
        elif n_seen > 0:
            clipped = True
            corners = np.empty((3, 3))
            for axis in range(3):
                corners[0, axis] = points[a, axis]
                corners[1, axis] = points[b, axis]
                corners[2, axis] = points[c, axis]
            fill_clipped(corners, intrinsics, label, inverse_depth, labels)
    if clipped:
        return 0, height, 0, width
    if low_u > width - 1 or high_u < 0 or low_v > height - 1 or high_v < 0:
        return 0, 0, 0, 0
    return (
        int(max(low_v, 0.0)),
        int(min(high_v, height - 1.0)) + 1,
        int(max(low_u, 0.0)),
        int(min(high_u, width - 1.0)) + 1,
    )


@numba.njit(nogil=True, cache=True)
def finish_depth(depth: Depth, top: int, bottom: int, left: int, right: int) -> None:
    """Turn inverse depths into metres within a window, in place; 0 stays 0."""
    for row in range(top, bottom):
        for column in range(left, right):
            if depth[row, column] > 0:
                depth[row, column] = np.float32(1.0) / depth[row, column]


@numba.njit(nogil=True, cache=True)
def face_normals(points: Floats, faces: Faces) -> Depth:
    """(F, 3) unit normals of triangles, turned to the camera's side, in the points' frame."""
    normals = np.zeros((len(faces), 3), dtype=np.float32)
    for f in range(len(faces)):
        p, q, r = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        length = math.sqrt(x * x + y * y + z * z)
        if length == 0:
            continue
        if x * p[0] + y * p[1] + z * p[2] > 0:
            length = -length
        normals[f, 0], normals[f, 1], normals[f, 2] = x / length, y / length, z / length
    return normals


@numba.njit(nogil=True, cache=True)
def resolve_faces(
    face_label: npt.NDArray[np.int32],
    normals: Depth,
    part_of_face: npt.NDArray[np.uint8],
    part_id: npt.NDArray[np.uint8],
    normal: Depth,
) -> None:
    """From face labels (H, W; 0 nothing, f + 1) to part ids (H, W) and normals (H, W, 3)."""
    for row in range(face_label.shape[0]):
        for column in range(face_label.shape[1]):
            f = face_label[row, column] - 1
            if f >= 0:
                part_id[row, column] = part_of_face[f]
                for axis in range(3):
                    normal[row, column, axis] = normals[f, axis]
