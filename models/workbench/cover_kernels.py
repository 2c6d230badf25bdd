"""Numba kernels of the stage: what moves comes before what stands; where its shadow may fall."""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

from snapfit.models.workbench.kernels import Lamps

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

_FAST = {"nogil": True, "cache": True, "error_model": "numpy", "fastmath": True}
# As in `kernels`: a point is lifted by so many texels before it looks for the lamp.
_LIFT_TEXELS = 1.8
UNTOUCHED, MOVING, SHADOWED = 0, 1, 2


@numba.njit(**_FAST)
def put_before(
    depth: Singles,
    normal: Singles,
    albedo: Singles,
    gloss: Singles,
    label: Bytes,
    seen_depth: Singles,
    seen_normal: Singles,
    seen_id: Bytes,
    colors: Singles,
    glosses: Singles,
    labels: Bytes,
    mark: Bytes,
) -> None:
    """Puts bodies in front of surfaces, in place.

    Args:
        depth: (H, W) m.
        normal: (H, W, 3).
        albedo: (H, W, 3) linear.
        gloss: (H, W).
        label: (H, W).
        seen_depth: (H, W) of the bodies, 0 is nothing.
        seen_normal: (H, W, 3) of the bodies.
        seen_id: (H, W) i + 1 is the i-th body.
        colors: (bodies, 3) linear.
        glosses: (bodies,).
        labels: (bodies,).
        mark: (H, W) is written: `MOVING` where a body is seen, else `UNTOUCHED`.
    """
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            z = seen_depth[row, column]
            mark[row, column] = UNTOUCHED
            if z > 0 and z < depth[row, column]:
                body = seen_id[row, column] - 1
                depth[row, column] = z
                gloss[row, column] = glosses[body]
                label[row, column] = labels[body]
                mark[row, column] = MOVING
                for c in range(3):
                    normal[row, column, c] = seen_normal[row, column, c]
                    albedo[row, column, c] = colors[body, c]


@numba.njit(**_FAST)
def mark_shadowed(
    depth: Singles, normal: Singles, intrinsics: Floats, lamps: Lamps, first: int, mark: Bytes
) -> Singles:
    """Marks the surfaces that shadow maps from the `first` on may reach.

    Args:
        depth: (H, W) m.
        normal: (H, W, 3).
        intrinsics: (4,) fx, fy, cx, cy, px.
        lamps: with their shadow maps.
        first: shadow map.
        mark: (H, W) `UNTOUCHED` becomes `SHADOWED`.

    Returns:
        (H, W) the depth where something is marked, 0 elsewhere.
    """
    out = np.zeros_like(depth)
    height, width = lamps.shadows.shape[1], lamps.shadows.shape[2]
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            pz = np.float64(depth[row, column])
            if mark[row, column] == UNTOUCHED and pz > 0:
                px = (column - intrinsics[2]) / intrinsics[0] * pz
                py = (row - intrinsics[3]) / intrinsics[1] * pz
                for m in range(first, len(lamps.map_lamp)):
                    t, lens = lamps.lamp_from_camera[m], lamps.lenses[m]
                    lamp = lamps.rows[lamps.map_lamp[m]]
                    x, y, z = lamp[0] - px, lamp[1] - py, lamp[2] - pz
                    lift = _LIFT_TEXELS * math.sqrt(x * x + y * y + z * z) / lens[0]
                    x = px + lift * normal[row, column, 0]
                    y = py + lift * normal[row, column, 1]
                    z = pz + lift * normal[row, column, 2]
                    away = t[2, 0] * x + t[2, 1] * y + t[2, 2] * z + t[2, 3]
                    u = lens[0] * (t[0, 0] * x + t[0, 1] * y + t[0, 2] * z + t[0, 3]) / away
                    v = lens[1] * (t[1, 0] * x + t[1, 1] * y + t[1, 2] * z + t[1, 3]) / away
                    u, v = u + lens[2], v + lens[3]
                    if 0 <= u < width and 0 <= v < height and lamps.casts[m, int(v), int(u)] != 0:
                        mark[row, column] = SHADOWED
                        break
            if mark[row, column] != UNTOUCHED:
                out[row, column] = depth[row, column]
    return out


@numba.njit(**_FAST)
def unit_where(mean: Singles, ids: Bytes, first: int, normal: Singles) -> None:
    """Takes smoothed normals (H, W, 3), made unit, where the body's id is `first` or more."""
    for row in range(ids.shape[0]):
        for column in range(ids.shape[1]):
            if ids[row, column] < first:
                continue
            x, y, z = mean[row, column, 0], mean[row, column, 1], mean[row, column, 2]
            length = math.sqrt(x * x + y * y + z * z)
            if length > 1e-6:
                normal[row, column, 0] = x / length
                normal[row, column, 1] = y / length
                normal[row, column, 2] = z / length


@numba.njit(**_FAST)
def only_where(normal: Singles, ids: Bytes, first: int) -> Singles:
    """Normals (H, W, 3) where the body's id is `first` or more, zero elsewhere."""
    out = np.zeros_like(normal)
    for row in range(ids.shape[0]):
        for column in range(ids.shape[1]):
            if ids[row, column] >= first:
                for c in range(3):
                    out[row, column, c] = normal[row, column, c]
    return out
