"""The depth modality's correspondences (Stoiber et al., ICG, CVPR 2022)."""

from __future__ import annotations

import numpy as np
from numba import njit

from snapfit.tracking.kernels.geometry import intrinsics, rotate, transform
from snapfit.tracking.kernels.occlusion import hidden
from snapfit.tracking.kernels.types import (
    CONSIDERED,
    F32,
    FAST,
    I16,
    I64,
    NORMAL_UNIT,
    OCCLUDED,
    U16,
    VALID,
    Bodies,
    Cameras,
    DepthSettings,
    Images,
    Intrinsics,
    OcclusionSettings,
    Points,
)

_NO_DEPTH = 65535


@njit(cache=True, nogil=True, fastmath=FAST)
def find_points(
    body: int,
    first: int,
    last: int,
    iteration: int,
    images: Images,
    cameras: Cameras,
    bodies: Bodies,
    surface: I16,
    unit: np.float32,
    settings: DepthSettings,
    occlusion: OcclusionSettings,
    points: Points,
    counts: I64,
    found: F32,
) -> None:
    """Closest measured points of surface points first..last of a body, for one iteration.

    Args:
        body: index of the body.
        first, last: range of the surface points, last excluded.
        iteration: correspondence iteration, selects distance and deviation.
        images, cameras: what is seen.
        bodies: poses are read.
        surface: (N, 7) the view's surface points; see `ViewpointModel.surface`.
        unit: metres a count of `surface`.
        settings, occlusion: parameters.
        points: written.
        counts: (4,) written: considered, occluded, valid points of this range.
        found: (3,) room for one measured point.
    """
    camera, color_camera = intrinsics(cameras.depth), intrinsics(cameras.color)
    # Rows of arrays are taken once, out of the loop: each costs a counted reference.
    depth_pose, color_pose = bodies.depth_poses[body], bodies.color_poses[body]
    point_of, normal_of = points.point[body], points.normal[body]
    measured_of, weight_of = points.measured[body], points.weight[body]
    valid_of = points.valid[body]
    scale = bodies.depth_scales[body]
    for i in range(first, last):
        valid_of[i] = 0
        px, py, pz = surface[i, 0] * unit, surface[i, 1] * unit, surface[i, 2] * unit
        x, y, z = transform(depth_pose, px, py, pz)
        cx, cy, cz = transform(color_pose, px, py, pz)
        if z <= 0.0 or cz <= 0.0:
            continue
        u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
        if not (0.0 <= u < camera.width - 1 and 0.0 <= v < camera.height - 1):
            continue
        counts[CONSIDERED] += 1
        offset = surface[i, 6] * unit
        color_u = color_camera.fx * cx / cz + color_camera.cx
        color_v = color_camera.fy * cy / cz + color_camera.cy
        if hidden(body, images, cameras, x, y, z, offset, color_u, color_v, cz, occlusion):
            counts[OCCLUDED] += 1
            continue
        if not closest_measured(
            images.depth,
            camera,
            cameras.depth_unit,
            settings.strides[iteration],
            settings.considered[iteration],
            x,
            y,
            z,
            found,
        ):
            continue
        bx = surface[i, 3] * NORMAL_UNIT
        by = surface[i, 4] * NORMAL_UNIT
        bz = surface[i, 5] * NORMAL_UNIT
        nx, ny, nz = rotate(depth_pose, bx, by, bz)
        ex, ey, ez = found[0] - x, found[1] - y, found[2] - z
        along = nx * ex + ny * ey + nz * ez
        beside2 = ex * ex + ey * ey + ez * ez - along * along
        limit = settings.beside * settings.strides[iteration] * z + settings.beside_slope * abs(
            along
        )
        if beside2 > limit * limit:
            continue
        mx, my, mz = transform(cameras.color_from_depth, found[0], found[1], found[2])
        point_of[i, 0], point_of[i, 1], point_of[i, 2] = px, py, pz
        normal_of[i, 0], normal_of[i, 1], normal_of[i, 2] = bx, by, bz
        measured_of[i, 0], measured_of[i, 1], measured_of[i, 2] = mx, my, mz
        deviation = settings.sigmas[iteration] * scale * z
        weight_of[i] = np.float32(1.0) / (deviation * deviation)
        valid_of[i] = 1
        counts[VALID] += 1


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def closest_measured(
    depth: U16,
    camera: Intrinsics,
    unit: np.float32,
    stride_m: np.float32,
    considered: np.float32,
    x: np.float32,
    y: np.float32,
    z: np.float32,
    found: F32,
) -> bool:
    """The measured point closest to (x, y, z), depth camera frame, m, in a square window.

    The window and its stride are proportional to depth, so that they are constant in pixels.

    Args:
        depth: (H, W) depth image.
        camera: the depth camera.
        unit: metres a count of `depth`.
        stride_m: spacing of the samples, at 1 m.
        considered: farthest distance at 1 m, half the window's size.
        x, y, z: the model's point.
        found: (3,) written.

    Returns:
        False where nothing is measured within the considered distance.
    """
    u = camera.fx * x / z + camera.cx
    v = camera.fy * y / z + camera.cy
    stride = max(1, int(stride_m * camera.fx + np.float32(0.5)))
    steps = max(1, int(considered * camera.fx / stride + np.float32(0.5)))
    u_center, v_center = int(u + 0.5), int(v + 0.5)
    u_low = u_center - stride * min(steps, u_center // stride)
    v_low = v_center - stride * min(steps, v_center // stride)
    u_high = min(u_center + stride * steps, camera.width - 1)
    v_high = min(v_center + stride * steps, camera.height - 1)
    inverse_fx = np.float32(1.0) / camera.fx
    inverse_fy = np.float32(1.0) / camera.fy
    limit = considered * z
    best = limit * limit
    hit = False
    for row in range(v_low, v_high + 1, stride):
        ray_y = (row - camera.cy) * inverse_fy
        for column in range(u_low, u_high + 1, stride):
            count = depth[row, column]
            if count == 0 or count == _NO_DEPTH:
                continue
            mz = count * unit
            dx = (column - camera.cx) * inverse_fx * mz - x
            dy = ray_y * mz - y
            dz = mz - z
            distance = dx * dx + dy * dy + dz * dz
            if distance < best:
                best = distance
                found[0], found[1], found[2] = dx + x, dy + y, mz
                hit = True
    return hit
