"""Is a point of a body hidden? By something measured (a hand), or by another tracked part."""

from __future__ import annotations

import numpy as np
from numba import njit

from snapfit.tracking.kernels.geometry import intrinsics
from snapfit.tracking.kernels.types import (
    F32,
    FAST,
    U8,
    U16,
    Cameras,
    Images,
    Intrinsics,
    OcclusionSettings,
)

_SAMPLES_A_SIDE = 4
_NO_DEPTH = 65535


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def hidden(
    body: int,
    images: Images,
    cameras: Cameras,
    x: np.float32,
    y: np.float32,
    z: np.float32,
    offset: np.float32,
    color_u: np.float32,
    color_v: np.float32,
    color_z: np.float32,
    settings: OcclusionSettings,
) -> bool:
    """Whether a point of a body is hidden, in either way.

    Args:
        body: index of the body.
        images, cameras: what is seen.
        x, y, z: the point in the depth camera's frame, m.
        offset: how much nearer the body's own surface comes within the radius, m.
        color_u, color_v, color_z: the point in the colour image, px, and its depth there, m.
        settings: which of the two, radius and thresholds.
    """
    if settings.modelled and images.neighboured[body]:
        radius_px = settings.radius * cameras.color[0] / color_z
        if hidden_modelled(
            images.near_depth,
            images.near_id,
            body + 1,
            color_u,
            color_v,
            color_z,
            radius_px,
            settings,
        ):
            return True
    return settings.measured and hidden_measured(
        images.depth,
        intrinsics(cameras.depth),
        cameras.depth_unit,
        x,
        y,
        z,
        offset + images.hiding[body],
        settings,
    )


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def hidden_measured(
    depth: U16,
    camera: Intrinsics,
    unit: np.float32,
    x: np.float32,
    y: np.float32,
    z: np.float32,
    offset: np.float32,
    settings: OcclusionSettings,
) -> bool:
    """Whether the depth image shows something nearer around a point (depth camera frame, m).

    Args:
        depth: (H, W) depth image, `unit` metres a count.
        camera: the depth camera.
        unit: metres a count.
        x, y, z: the point.
        offset: how much nearer something must be to hide the point, m.
        settings: radius.
    """
    if z <= 0.0:
        return False
    limit = int((z - offset) / unit)
    u = camera.fx * x / z + camera.cx
    v = camera.fy * y / z + camera.cy
    radius = settings.radius * camera.fx / z
    stride = max(1, int(2.0 * radius / _SAMPLES_A_SIDE + 1.0))
    u_low = max(int(u - radius + 0.5), 0)
    v_low = max(int(v - radius + 0.5), 0)
    u_high = min(int(u + radius + 0.5), camera.width - 1)
    v_high = min(int(v + radius + 0.5), camera.height - 1)
    for row in range(v_low, v_high + 1, stride):
        for column in range(u_low, u_high + 1, stride):
            value = int(depth[row, column])
            if 0 < value < limit and value != _NO_DEPTH:
                return True
    return False


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def hidden_modelled(
    near_depth: F32,
    near_id: U8,
    own_id: int,
    u: np.float32,
    v: np.float32,
    z: np.float32,
    radius_px: np.float32,
    settings: OcclusionSettings,
) -> bool:
    """Whether another tracked part is nearer at an image place (colour image px).

    Args:
        near_depth, near_id: the small rendering of all bodies; depth in m, 0 is nothing.
        own_id: the body's id in it.
        u, v: the place in the colour image.
        z: the point's depth, m.
        radius_px: around the place, colour image px.
        settings: image scale and threshold.
    """
    height, width = near_depth.shape
    scale = settings.image_scale
    column = (u + 0.5) * scale - 0.5
    row = (v + 0.5) * scale - 0.5
    reach = max(radius_px * scale, np.float32(0.5))
    limit = z - settings.modelled_threshold
    for i in range(max(int(row - reach + 0.5), 0), min(int(row + reach + 0.5), height - 1) + 1):
        for j in range(
            max(int(column - reach + 0.5), 0), min(int(column + reach + 0.5), width - 1) + 1
        ):
            if near_id[i, j] != 0 and near_id[i, j] != own_id and near_depth[i, j] < limit:
                return True
    return False
