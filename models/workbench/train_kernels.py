"""Numba kernels of the training images: the flat things around, and what a lens adds."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

_FAST = {"nogil": True, "cache": True, "error_model": "numpy", "fastmath": True}


class Sheets(NamedTuple):
    """Flat rectangles: bench, floor, wall, and what lies flat on the bench.

    Attributes:
        frames: (P, 3, 4) camera frame: columns are the two directions along it, its normal, and
            its middle, m.
        halves: (P, 2) half its width and height, m.
        windows: (P, 4) columns from, to, rows from, to, between which it may be seen, px.
        surface: (P,) which of the stock it shows.
        texels: (P, 4) pixels a metre; turn, rad; shift along both directions, pixels.
        color: (P, 3, 4) linear colour (blue first) from that of the surface, affine.
        gloss: (P,).
    """

    frames: Floats
    halves: Floats
    windows: npt.NDArray[np.int64]
    surface: npt.NDArray[np.int64]
    texels: Floats
    color: Singles
    gloss: Singles


@numba.njit(inline="always", **_FAST)
def mirrored(index: int, side: int) -> int:
    """The place of a pixel, from -1 to 2 side, in a picture that goes on as its mirror image."""
    if index < 0:
        return 0
    return index if index < side else max(2 * side - 1 - index, 0)


@numba.njit(**_FAST)
def hit_sheets(sheets: Sheets, intrinsics: Floats, depth: Singles, which: Bytes) -> None:
    """Which flat thing each pixel sees first.

    Args:
        sheets: all of them.
        intrinsics: (4,) fx, fy, cx, cy, px.
        depth: (H, W) is written: m, 0 where none is.
        which: (H, W) is written: i + 1 is the i-th sheet, 0 none.
    """
    depth[:] = 0
    which[:] = 0
    for p in range(len(sheets.halves)):
        f = sheets.frames[p]
        left, right, top, bottom = sheets.windows[p]
        offset = f[0, 2] * f[0, 3] + f[1, 2] * f[1, 3] + f[2, 2] * f[2, 3]
        for row in range(top, bottom):
            y = (row - intrinsics[3]) / intrinsics[1]
            for column in range(left, right):
                x = (column - intrinsics[2]) / intrinsics[0]
                z = offset / (x * f[0, 2] + y * f[1, 2] + f[2, 2])
                if not 0 < z < 50 or (which[row, column] and z >= depth[row, column]):
                    continue
                a, b, c = x * z - f[0, 3], y * z - f[1, 3], z - f[2, 3]
                u = a * f[0, 0] + b * f[1, 0] + c * f[2, 0]
                v = a * f[0, 1] + b * f[1, 1] + c * f[2, 1]
                if abs(u) <= sheets.halves[p, 0] and abs(v) <= sheets.halves[p, 1]:
                    depth[row, column] = z
                    which[row, column] = p + 1


@numba.njit(**_FAST)
def paint_sheets(
    sheets: Sheets,
    stock: Bytes,
    light_of_byte: Singles,
    intrinsics: Floats,
    depth: Singles,
    which: Bytes,
    normal: Singles,
    albedo: Singles,
    gloss: Singles,
) -> None:
    """Colours and normals of flat things that are seen.

    Args:
        sheets: all of them.
        stock: (N, S, 2 S, 3) surfaces with their mip levels, sRGB.
        light_of_byte: (256,) linear light of a byte.
        intrinsics: (4,) fx, fy, cx, cy, px.
        depth: (H, W) of `hit_sheets`.
        which: (H, W) of `hit_sheets`.
        normal: (H, W, 3) is written.
        albedo: (H, W, 3) linear, is written.
        gloss: (H, W) is written.
    """
    side = stock.shape[1]
    seen = np.empty(3, np.float32)
    turns = np.empty((len(sheets.halves), 2))
    for p in range(len(turns)):
        turns[p, 0], turns[p, 1] = math.cos(sheets.texels[p, 1]), math.sin(sheets.texels[p, 1])
    for row in range(depth.shape[0]):
        ray_y = (row - intrinsics[3]) / intrinsics[1]
        for column in range(depth.shape[1]):
            p = int(which[row, column]) - 1
            if p < 0:
                normal[row, column] = 0
                albedo[row, column] = 0
                gloss[row, column] = 0
                continue
            f, z = sheets.frames[p], np.float64(depth[row, column])
            ray_x = (column - intrinsics[2]) / intrinsics[0]
            facing = abs(ray_x * f[0, 2] + ray_y * f[1, 2] + f[2, 2])
            a, b, c = ray_x * z - f[0, 3], ray_y * z - f[1, 3], z - f[2, 3]
            u = a * f[0, 0] + b * f[1, 0] + c * f[2, 0]
            v = a * f[0, 1] + b * f[1, 1] + c * f[2, 1]
            ppm, cosine, sine = sheets.texels[p, 0], turns[p, 0], turns[p, 1]
            s = ppm * (cosine * u - sine * v) + sheets.texels[p, 2]
            t = ppm * (sine * u + cosine * v) + sheets.texels[p, 3]
            # Texels a pixel, between those along the slope and those across it.
            step = ppm * z / intrinsics[0] / math.sqrt(max(facing, 0.02))
            n, first, size = 1.0, 0, side
            while step > 1.4 * n and size > side // 16:
                n *= 2
                first += size
                size //= 2
            s, t = s / n - 0.5, t / n - 0.5
            s -= 2 * size * math.floor(s / (2 * size))
            t -= 2 * size * math.floor(t / (2 * size))
            i, j = math.floor(t), math.floor(s)
            di, dj = np.float32(t - i), np.float32(s - j)
            i0, i1 = mirrored(i, size), mirrored(i + 1, size)
            j0, j1 = first + mirrored(j, size), first + mirrored(j + 1, size)
            surface = stock[sheets.surface[p]]
            for k in range(3):
                upper = light_of_byte[surface[i0, j0, k]] * (1 - dj)
                upper += light_of_byte[surface[i0, j1, k]] * dj
                lower = light_of_byte[surface[i1, j0, k]] * (1 - dj)
                lower += light_of_byte[surface[i1, j1, k]] * dj
                seen[k] = upper * (1 - di) + lower * di
            for k in range(3):
                m = sheets.color[p, k]
                value = m[0] * seen[0] + m[1] * seen[1] + m[2] * seen[2] + m[3]
                albedo[row, column, k] = min(max(value, np.float32(0.004)), np.float32(0.92))
                normal[row, column, k] = f[k, 2]
            gloss[row, column] = sheets.gloss[p]


@numba.njit(**_FAST)
def expose(
    light: Singles, gain: Singles, falloff: float, shoulder: float, encoding: Bytes
) -> Bytes:
    """Linear light (H, W, 3) as the camera's bytes.

    Args:
        light: linear.
        gain: (3,) exposure and white balance.
        falloff: how much darker the corners are.
        shoulder: from this light on highlights are pressed together, 0 to 1.
        encoding: (N,) sRGB bytes of equal steps of the square root of light.
    """
    height, width = light.shape[:2]
    out = np.empty(light.shape, dtype=np.uint8)
    last = len(encoding) - 1
    for row in range(height):
        y = 2 * row / height - 1
        for column in range(width):
            x = 2 * column / width - 1
            fall = 1 - falloff * (x * x + y * y) / 2
            for c in range(3):
                value = max(light[row, column, c] * gain[c] * fall, 0.0)
                if value > shoulder:
                    room = 1 - shoulder
                    value = shoulder + room * (1 - math.exp(-(value - shoulder) / room))
                out[row, column, c] = encoding[int(math.sqrt(min(value, 1.0)) * last + 0.5)]
    return out
