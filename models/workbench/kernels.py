"""Numba kernels of the workbench: light with soft shadows, and pixels from samples.

Light is linear; points, normals and lights are in the colour camera's frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]
Triple = tuple[float, float, float]

_FAST = {"nogil": True, "cache": True, "error_model": "numpy", "fastmath": True}
SEARCH_TAPS, FILTER_TAPS = 14, 24
_SHADOW_BIAS_M = 0.0015
# A surface point is lifted by this along its normal before it looks for the lamp.
_LIFT_TEXELS = 1.8
_SAME_SURFACE_M, _SAME_COSINE = 0.003, 0.98
# A blocker is looked for up to this share of the way from the surface to the light.
_SEARCH_SHARE = 0.12


class Lamps(NamedTuple):
    """All lamps with their shadow maps, as the kernels take them.

    Attributes:
        rows: (L, 7) position m (camera frame), diameter m, intensity of three channels at 1 m.
        ambient: (2, 3) light from above and from below.
        up: (3,) unit, away from the bench.
        map_lamp: (M,) the lamp to which a shadow map belongs.
        lamp_from_camera: (M, 4, 4).
        lenses: (M, 4) fx, fy, cx, cy of the shadow maps, px.
        shadows: (M, H, W) depth seen from the lamp, m; 0 is nothing.
        casts: (M, H, W) 0 where no blocker is in reach.
        taps: (search and filter taps, 2) offsets in a unit disc, the former first.
    """

    rows: Floats
    ambient: Floats
    up: Floats
    map_lamp: npt.NDArray[np.int64]
    lamp_from_camera: Floats
    lenses: Floats
    shadows: Singles
    casts: Bytes
    taps: Floats


@numba.njit(**_FAST)
def search_radius_px(size_m: float, px_per_m: float) -> float:
    """How far around a point blockers are looked for in the shadow map of a lamp of this size."""
    return max(1.5, 0.5 * size_m * _SEARCH_SHARE / (1 - _SEARCH_SHARE) * px_per_m)


@numba.njit(inline="always", **_FAST)
def share_lit(
    shadow: Singles,
    focal_px: float,
    taps: Floats,
    size_m: float,
    seen: Triple,
    bias: tuple[float, float],
    turn: tuple[float, float],
) -> float:
    """Share of a lamp that a point sees: percentage-closer soft shadows (Fernando, 2005).

    Args:
        shadow: (H, W) depth seen from the lamp, m; 0 is nothing.
        focal_px: of the shadow map.
        taps: (search and filter taps, 2) offsets in a unit disc, the former first.
        size_m: diameter of the lamp.
        seen: where the lamp sees the point: u and v in px, depth in m.
        bias: how much nearer a blocker must be, m; and that for each px to the side.
        turn: cosine and sine of the angle by which the taps are turned.
    """
    u, v, z = seen
    height, width = shadow.shape
    radius = search_radius_px(size_m, focal_px / z)
    total, n_blockers = 0.0, 0
    for i in range(SEARCH_TAPS):
        dx, dy = radius * taps[i, 0], radius * taps[i, 1]
        column, row = int(u + turn[0] * dx - turn[1] * dy), int(v + turn[1] * dx + turn[0] * dy)
        nearest = z - bias[0] - bias[1] * (abs(dx) + abs(dy))
        if 0 <= row < height and 0 <= column < width and 0 < shadow[row, column] < nearest:
            total += shadow[row, column]
            n_blockers += 1
    lit = 1.0
    if n_blockers > 0:
        blocker = total / n_blockers
        radius = max(1.0, 0.5 * size_m * (z - blocker) / blocker * focal_px / z)
        for i in range(SEARCH_TAPS, SEARCH_TAPS + FILTER_TAPS):
            dx, dy = radius * taps[i, 0], radius * taps[i, 1]
            column, row = int(u + turn[0] * dx - turn[1] * dy), int(v + turn[1] * dx + turn[0] * dy)
            nearest = z - bias[0] - bias[1] * (abs(dx) + abs(dy))
            if 0 <= row < height and 0 <= column < width and 0 < shadow[row, column] < nearest:
                lit -= 1 / FILTER_TAPS
    return lit


@numba.njit(**_FAST)
def choose_sources(
    depth: Singles, normal: Singles, row: int, source: npt.NDArray[np.int64]
) -> None:
    """Which sample's shadow each sample of a row takes: its own, or that beside it in 2 x 2.

    Args:
        depth: (H, W) m.
        normal: (H, W, 3).
        row: of the samples.
        source: (W,) is written: the row of `lit` in `shade`; even rows first, then odd ones.
    """
    width = depth.shape[1]
    for column in range(width):
        even_row, even_column = row & ~1, column & ~1
        source[column] = column + width * (row & 1)
        if abs(depth[row, column] - depth[even_row, even_column]) < _SAME_SURFACE_M:
            cosine = 0.0
            for axis in range(3):
                cosine += normal[row, column, axis] * normal[even_row, even_column, axis]
            if cosine > _SAME_COSINE:
                source[column] = even_column


@numba.njit(**_FAST)
def cast_shadow(
    depth: Singles,
    normal: Singles,
    intrinsics: Floats,
    origin: npt.NDArray[np.int64],
    row: int,
    source: npt.NDArray[np.int64],
    lamps: Lamps,
    m: int,
    lit: Floats,
) -> None:
    """Lowers the share of a lamp that the samples of a row see by what one shadow map says.

    Args:
        depth: as in `shade`.
        normal: as in `shade`.
        intrinsics: as in `shade`.
        origin: as in `shade`.
        row: of the samples.
        source: (W,) of `choose_sources`.
        lamps: as in `shade`.
        m: the shadow map.
        lit: (2 W, L) is lowered.
    """
    k, t, taps = lamps.map_lamp[m], lamps.lamp_from_camera[m], lamps.taps
    shadow, cast, lens, lamp = lamps.shadows[m], lamps.casts[m], lamps.lenses[m], lamps.rows[k]
    height, width = shadow.shape
    for column in range(depth.shape[1]):
        own = column + depth.shape[1] * (row & 1)
        pz = np.float64(depth[row, column])
        if source[column] != own or pz <= 0:
            continue
        px = (column - intrinsics[2]) / intrinsics[0] * pz
        py = (row - intrinsics[3]) / intrinsics[1] * pz
        nx, ny, nz = normal[row, column, 0], normal[row, column, 1], normal[row, column, 2]
        x, y, z = lamp[0] - px, lamp[1] - py, lamp[2] - pz
        distance = math.sqrt(x * x + y * y + z * z)
        cosine = (nx * x + ny * y + nz * z) / distance
        if cosine <= 0:
            lit[own, k] = 0.0
            continue
        lift_m = _LIFT_TEXELS * distance / lens[0]
        px, py, pz = px + lift_m * nx, py + lift_m * ny, pz + lift_m * nz
        z = t[2, 0] * px + t[2, 1] * py + t[2, 2] * pz + t[2, 3]
        u = lens[0] * (t[0, 0] * px + t[0, 1] * py + t[0, 2] * pz + t[0, 3]) / z + lens[2]
        v = lens[1] * (t[1, 0] * px + t[1, 1] * py + t[1, 2] * pz + t[1, 3]) / z + lens[3]
        if not (0 <= u < width and 0 <= v < height) or cast[int(v), int(u)] == 0:
            continue
        # Only steep faces need it; on the bench it would take the shadows of low things away.
        slope = min(max(math.sqrt(1 - min(cosine * cosine, 1.0)) / cosine - 1.0, 0.0), 4.0)
        # Interleaved gradient noise (Jimenez, 2014) turns the taps from place to place.
        grain = 0.06711056 * (column + origin[0]) + 0.00583715 * (row + origin[1])
        angle = 2 * math.pi * 52.9829189 * (grain - math.floor(grain))
        share = share_lit(
            shadow,
            lens[0],
            taps,
            lamp[3],
            (u, v, z),
            (_SHADOW_BIAS_M, slope * z / lens[0]),
            (math.cos(angle), math.sin(angle)),
        )
        lit[own, k] = min(lit[own, k], share)


@numba.njit(**_FAST)
def light_of(point: Triple, normal: Triple, gloss: float, lamp: Triple) -> tuple[float, float]:
    """What an unshadowed lamp sends from a surface point to the eye, by unit of its intensity.

    Returns:
        Lambert's share, to be multiplied with the albedo, and Blinn and Phong's highlight.
    """
    x, y, z = lamp[0] - point[0], lamp[1] - point[1], lamp[2] - point[2]
    squared = x * x + y * y + z * z
    away = 1 / math.sqrt(squared)
    cosine = (normal[0] * x + normal[1] * y + normal[2] * z) * away
    if cosine <= 0:
        return 0.0, 0.0
    strength = cosine / squared
    if gloss <= 0:
        return strength, 0.0
    near = 1 / math.sqrt(point[0] * point[0] + point[1] * point[1] + point[2] * point[2])
    x, y, z = x * away - point[0] * near, y * away - point[1] * near, z * away - point[2] * near
    facing = max(normal[0] * x + normal[1] * y + normal[2] * z, 0.0)
    # The cosine of the half vector to the power of 24.
    power = facing * facing / (x * x + y * y + z * z)
    power = power * power * power
    power = power * power
    return strength, strength * gloss * power * power


@numba.njit(**_FAST)
def shade(
    depth: Singles,
    normal: Singles,
    albedo: Singles,
    gloss: Singles,
    intrinsics: Floats,
    origin: npt.NDArray[np.int64],
    lamps: Lamps,
) -> Singles:
    """What surfaces send to the camera under lamps with soft shadows and light from all around.

    Args:
        depth: (H, W) m; 0 is nothing and stays black.
        normal: (H, W, 3) unit, to the camera's side.
        albedo: (H, W, 3) 0 to 1, linear.
        gloss: (H, W) strength of the highlight.
        intrinsics: (4,) fx, fy, cx, cy in px of this window.
        origin: (2,) column and row of the window in the whole picture, even.
        lamps: with their shadow maps.

    Returns:
        (H, W, 3) linear light.
    """
    height, width = depth.shape
    out = np.zeros((height, width, 3), dtype=np.float32)
    up, sky, rows = lamps.up, lamps.ambient, lamps.rows
    lit = np.ones((2 * width, len(rows)))
    source = np.empty(width, dtype=np.int64)
    for row in range(height):
        choose_sources(depth, normal, row, source)
        first = width * (row & 1)
        lit[first : first + width] = 1.0
        for m in range(len(lamps.map_lamp)):
            cast_shadow(depth, normal, intrinsics, origin, row, source, lamps, m, lit)
        for column in range(width):
            z = np.float64(depth[row, column])
            if z <= 0:
                continue
            x = (column - intrinsics[2]) / intrinsics[0] * z
            y = (row - intrinsics[3]) / intrinsics[1] * z
            nx, ny, nz = normal[row, column, 0], normal[row, column, 1], normal[row, column, 2]
            upward = 0.5 + 0.5 * (nx * up[0] + ny * up[1] + nz * up[2])
            for c in range(3):
                ambient = sky[0, c] * upward + sky[1, c] * (1 - upward)
                out[row, column, c] = albedo[row, column, c] * ambient
            for k in range(len(rows)):
                share = lit[source[column], k]
                if share > 0:
                    lamp = (rows[k, 0], rows[k, 1], rows[k, 2])
                    matt, glint = light_of((x, y, z), (nx, ny, nz), gloss[row, column], lamp)
                    for c in range(3):
                        light = matt * albedo[row, column, c] + glint
                        out[row, column, c] += share * rows[k, 4 + c] * light
    return out


@numba.njit(**_FAST)
def to_pixels(samples: Singles, encoding: Bytes) -> Bytes:
    """Linear light at twice the size, with a border of 2, to sRGB pixels.

    Each pixel is the mean of 4 x 4 samples with the weights 1 3 3 1: its own and their neighbours,
    which softens edges as a lens does.

    Args:
        samples: (2 H + 4, 2 W + 4, 3) linear, 0 to 1; more is clipped.
        encoding: (N,) sRGB value of each of N equal steps of the square root of light.

    Returns:
        (H, W, 3) uint8 in the order of the channels of `samples`.
    """
    height, width = (samples.shape[0] - 4) // 2, (samples.shape[1] - 4) // 2
    weight = np.array([1.0, 3.0, 3.0, 1.0]) / 8
    out = np.empty((height, width, 3), dtype=np.uint8)
    last = len(encoding) - 1
    for row in range(height):
        for column in range(width):
            for c in range(3):
                total = 0.0
                for i in range(4):
                    line = 0.0
                    for j in range(4):
                        line += weight[j] * samples[2 * row + 1 + i, 2 * column + 1 + j, c]
                    total += weight[i] * line
                out[row, column, c] = encoding[int(math.sqrt(min(total, 1.0)) * last + 0.5)]
    return out
