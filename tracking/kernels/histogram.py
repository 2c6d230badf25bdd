"""The colour histograms: 16 bins a channel, of a body's foreground and of its background."""

from __future__ import annotations

import numpy as np
from numba import njit

from snapfit.tracking.kernels.types import F32, FAST, U8, Intrinsics, Lines


@njit(cache=True, nogil=True, fastmath=FAST)
def add_colors(
    body: int,
    n_lines: int,
    color: U8,
    camera: Intrinsics,
    pose: F32,
    lines: Lines,
    unconsidered_px: np.float32,
    considered_px: np.float32,
    counts: F32,
) -> None:
    """Count the colours on both sides of the contour at the final pose (M3T).

    Args:
        body: index of the body in `lines`.
        n_lines: lines to look at.
        color: (H, W, 3) BGR.
        camera: the colour camera.
        pose: (4, 4) camera_from_body.
        lines: the valid ones are used, with their normals and continuous distances.
        unconsidered_px, considered_px: from where to where along the normal.
        counts: (2, 4096) foreground and background, added to.
    """
    for i in range(n_lines):
        if lines.valid[body, i] == 0:
            continue
        point, place = lines.point[body, i], lines.place[body, i]
        z = pose[2, 0] * point[0] + pose[2, 1] * point[1] + pose[2, 2] * point[2] + pose[2, 3]
        x = pose[0, 0] * point[0] + pose[0, 1] * point[1] + pose[0, 2] * point[2] + pose[0, 3]
        y = pose[1, 0] * point[0] + pose[1, 1] * point[1] + pose[1, 2] * point[2] + pose[1, 3]
        if z <= 0.0:
            continue
        u = camera.fx * x / z + camera.cx
        v = camera.fy * y / z + camera.cy
        for side in range(2):
            sign = np.float32(-1.0) if side == 0 else np.float32(1.0)
            # Where the body is thin, its middle must not be left out.
            start = min(unconsidered_px, np.float32(0.25) * place[6 + side])
            length = min(considered_px, place[6 + side] - np.float32(2.0) * start)
            count_along(color, u, v, sign * place[2], sign * place[3], start, length, counts[side])


@njit(cache=True, nogil=True, fastmath=FAST)
def count_along(
    color: U8,
    u: np.float32,
    v: np.float32,
    du: np.float32,
    dv: np.float32,
    start_px: np.float32,
    length_px: np.float32,
    counts: F32,
) -> None:
    """Count the pixels of a ray, one for each step along its dominant axis."""
    height, width = color.shape[0], color.shape[1]
    dominant = max(abs(du), abs(dv))
    steps = int(length_px * dominant + np.float32(0.5))
    at_u = u + du * start_px + np.float32(0.5)
    at_v = v + dv * start_px + np.float32(0.5)
    step_u, step_v = du / dominant, dv / dominant
    for _ in range(steps):
        if at_u < 0.0 or at_v < 0.0:
            break
        column, row = int(at_u), int(at_v)
        if column >= width or row >= height:
            break
        counts[
            (int(color[row, column, 0]) >> 4 << 8)
            | (int(color[row, column, 1]) >> 4 << 4)
            | (int(color[row, column, 2]) >> 4)
        ] += np.float32(1.0)
        at_u += step_u
        at_v += step_v


@njit(cache=True, nogil=True, fastmath=FAST)
def blend(histogram: F32, counts: F32, rate: np.float32) -> None:
    """Histogram = (1 - rate) histogram + rate counts / sum(counts); counts are cleared.

    Args:
        histogram: (4096,) sums to one.
        counts: (4096,) of this frame.
        rate: share of this frame.
    """
    total = np.float32(0.0)
    for k in range(counts.shape[0]):
        total += counts[k]
    if total <= 0.0:
        return
    keep = np.float32(1.0) - rate
    scale = rate / total
    for k in range(counts.shape[0]):
        histogram[k] = keep * histogram[k] + scale * counts[k]
        counts[k] = np.float32(0.0)


@njit(cache=True, nogil=True, fastmath=FAST)
def posterior_table(foreground: F32, background: F32, table: F32) -> None:
    """Posterior of the foreground, by colour: hf / (hf + hb), 0.5 where neither was seen.

    One table of 16 KB stays in the first-level cache: one look-up a pixel, no division.
    """
    for k in range(table.shape[0]):
        total = foreground[k] + background[k]
        table[k] = foreground[k] / total if total > 0.0 else np.float32(0.5)
