"""The small rendering of all bodies at their predicted poses, for modelled occlusion."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from snapfit.models.raster_kernels import fill_body, finish_depth, to_camera
from snapfit.tracking.kernels.types import F32, F64, I32, I64, U8


@njit(cache=True, nogil=True)
def render_nearby(
    vertices: F32,
    faces: I32,
    starts: I64,
    centers: F32,
    radii: F64,
    active: U8,
    poses: F64,
    intrinsics: F64,
    near_depth: F32,
    near_id: U8,
    neighboured: U8,
) -> None:
    """Draw every body whose image may touch another's; the others cannot hide anything.

    Args:
        vertices, faces: simplified meshes one after the other, (V, 3) m, body frame, and (F, 3)
            with vertices counted from each body's first.
        starts: (B + 1, 2) where each body's vertices and faces begin; last, where they end.
        centers, radii: (B, 3) and (B,) bounding spheres, body frame, m.
        active: (B,) 1 where a body is to be drawn.
        poses: (B, 4, 4) camera_from_body.
        intrinsics: (4,) fx, fy, cx, cy of the small image, px.
        near_depth, near_id: (h, w) written; m, 0 is nothing; index + 1.
        neighboured: (B,) written; 1 where the body's image may touch another's.
    """
    n = poses.shape[0]
    near_depth[:] = np.float32(0.0)
    near_id[:] = np.uint8(0)
    circles = np.empty((n, 3))
    for b in range(n):
        pose, center = poses[b], centers[b]
        z = pose[2, 0] * center[0] + pose[2, 1] * center[1] + pose[2, 2] * center[2] + pose[2, 3]
        x = pose[0, 0] * center[0] + pose[0, 1] * center[1] + pose[0, 2] * center[2] + pose[0, 3]
        y = pose[1, 0] * center[0] + pose[1, 1] * center[1] + pose[1, 2] * center[2] + pose[1, 3]
        # Closer than its own radius, a body may be anywhere in the image.
        depth = max(z - radii[b], 1e-3)
        circles[b, 0] = intrinsics[0] * x / max(z, 1e-3) + intrinsics[2]
        circles[b, 1] = intrinsics[1] * y / max(z, 1e-3) + intrinsics[3]
        circles[b, 2] = intrinsics[0] * radii[b] / depth + 1.0
        neighboured[b] = 0
    for a in range(n):
        for b in range(a):
            du, dv = circles[a, 0] - circles[b, 0], circles[a, 1] - circles[b, 1]
            if (
                active[a]
                and active[b]
                and math.sqrt(du * du + dv * dv) < circles[a, 2] + circles[b, 2]
            ):
                neighboured[a] = 1
                neighboured[b] = 1
    top, bottom, left, right = near_depth.shape[0], 0, near_depth.shape[1], 0
    for b in range(n):
        if neighboured[b] == 0:
            continue
        points = to_camera(vertices[starts[b, 0] : starts[b + 1, 0]], poses[b])
        own_faces = faces[starts[b, 1] : starts[b + 1, 1]]
        window = fill_body(points, own_faces, intrinsics, b + 1, 0, near_depth, near_id)
        if window[1] > window[0]:
            top, bottom = min(top, window[0]), max(bottom, window[1])
            left, right = min(left, window[2]), max(right, window[3])
    if bottom > top:
        finish_depth(near_depth, top, bottom, left, right)
