"""Plain NumPy twins of the kernels: written from the equations, in double precision.

A kernel works in single precision; where a real number is rounded to a pixel the two may differ
by one when the number lies on the border. Twins that round say how near they came (`margin_px`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

N_SEGMENTS = 19
N_BINS = 12
N_TAPS = 8
EVEN = 0.5


def color_bins(color: Array) -> Array:
    """Pixels (..., 3) BGR to bins, 16 a channel."""
    b, g, r = np.moveaxis(color.astype(np.int64) // 16, -1, 0)
    return 256 * b + 16 * g + r


def margin_to_rounding(values: Array) -> Array:
    """How far numbers are from where rounding to the nearest integer jumps."""
    return np.abs((values + 0.5) - np.round(values + 0.5))


class LinePixels(NamedTuple):
    """The pixels of a correspondence line, from the inside of the body outwards.

    Attributes:
        uv: (n, 2) along the normal; one coordinate integer, the other real.
        along_px: (n,) place along the normal, from the centre.
        margin_px: (n,) how near the rounding to pixels is to a border.
        major: 0 where the line runs along the rows, 1 along the columns.
    """

    uv: Array
    along_px: Array
    margin_px: Array
    major: int


def line_pixels(center: Array, normal: Array, n: int) -> LinePixels:
    """The n consecutive pixels along the dominant axis whose middle is nearest to the centre."""
    major = 0 if abs(normal[0]) >= abs(normal[1]) else 1
    direction = np.sign(normal[major])
    first = np.floor(center[major] - direction * (n - 1) / 2 + 0.5)
    places = first + direction * np.arange(n)
    along = (places - center[major]) / normal[major]
    uv = center + along[:, None] * normal
    uv[:, major] = places
    margin = margin_to_rounding(uv[:, 1 - major])
    start_margin = margin_to_rounding(np.array(center[major] - direction * (n - 1) / 2))
    return LinePixels(uv, along, np.minimum(margin, start_margin), major)


def is_inside(pixels: LinePixels, width: int, height: int) -> bool:
    """Whether a line is in the image: up to the last pixel, across it up to the last but one."""
    last = np.array([width, height]) - 1.0
    last[1 - pixels.major] -= np.finfo(np.float64).eps * last[1 - pixels.major]
    return bool(((pixels.uv >= 0) & (pixels.uv <= last)).all())


class Segments(NamedTuple):
    """Segment probabilities of the foreground (19,), and what the posterior needs beside."""

    foreground: Array
    is_sure: Array
    offset_px: float
    segments_per_px: float


def segment_probabilities(
    color: Array, table: Array, pixels: LinePixels, normal: Array, scale: int
) -> Segments:
    """SRT3D, equations 8 and 9: p = prod pf / (prod pf + prod pb), 0.5 where both vanish."""
    column, row = np.floor(pixels.uv + 0.5).astype(int).T
    p = table[color_bins(color[row, column])].astype(np.float64).reshape(N_SEGMENTS, scale)
    foreground, background = p.prod(axis=1), (1 - p).prod(axis=1)
    total = foreground + background
    return Segments(
        np.divide(foreground, total, out=np.full(N_SEGMENTS, EVEN), where=total > 0),
        pixels.margin_px.reshape(N_SEGMENTS, scale).min(axis=1) > 2e-3,
        float(pixels.along_px.mean()),
        float(np.abs(normal).max() / scale),
    )


def posterior(foreground: Array, step: Array) -> Array:
    """SRT3D, equation 14: p(d) ~ prod_k (pf f_k + pb b_k), segments d .. d + 7."""
    windows = np.lib.stride_tricks.sliding_window_view(foreground.astype(np.float64), N_TAPS)
    p = (windows * step + (1 - windows) * (1 - step)).prod(axis=1)
    return p / p.sum()


def moments(distribution: Array, min_variance: float) -> tuple[float, float]:
    """Mean from the line's centre, and variance but no less than the smallest, segments."""
    offsets = np.arange(N_BINS) - (N_BINS - 1) / 2
    mean = float(distribution @ offsets)
    return mean, max(float(distribution @ (offsets - mean) ** 2), min_variance)


def window_pixels(center: int, reach: int, stride: int, size: int) -> Array:
    """Center - reach .. center + reach in strides from the centre; those in the image."""
    n = reach // stride
    pixels = center + stride * np.arange(-n, n + 1)
    return pixels[(pixels >= 0) & (pixels < size)]


def unprojected(rows: Array, columns: Array, depth_m: Array, fx_fy_cx_cy: Array) -> Array:
    """Pixels and their depths to points (..., 3), camera frame, m."""
    fx, fy, cx, cy = fx_fy_cx_cy
    return np.stack([(columns - cx) / fx * depth_m, (rows - cy) / fy * depth_m, depth_m], axis=-1)


def measured_window(
    depth: Array, fx_fy_cx_cy: Array, unit_m: float, stride_px: int, reach_px: int, point: Array
) -> Array:
    """All measured points (N, 3) in the square window around a point's image."""
    height, width = depth.shape
    fx, fy, cx, cy = fx_fy_cx_cy
    u, v = fx * point[0] / point[2] + cx, fy * point[1] / point[2] + cy
    columns = window_pixels(int(np.floor(u + 0.5)), reach_px, stride_px, width)
    rows = window_pixels(int(np.floor(v + 0.5)), reach_px, stride_px, height)
    row, column = np.meshgrid(rows, columns, indexing="ij")
    counts = depth[row, column].astype(np.int64)
    there = (counts > 0) & (counts < 65535)
    return unprojected(row[there], column[there], counts[there] * unit_m, fx_fy_cx_cy)


def rotation(vector: Array) -> Array:
    """The matrix exponential of a rotation vector, by its power series."""
    x, y, z = vector
    generator = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # Halve the angle until the series is short, then square.
    n_squarings = 8
    term, total = np.eye(3), np.eye(3)
    for n in range(1, 20):
        term = term @ generator / 2**n_squarings / n
        total = total + term
    return np.linalg.matrix_power(total, 2**n_squarings)


def ray_bins(color: Array, start: Array, direction: Array, length_px: float) -> tuple[Array, float]:
    """Counted colours (4096,) of a ray: a pixel for each step along the dominant axis; margin."""
    height, width = color.shape[:2]
    dominant = np.abs(direction).max()
    n = max(int(np.floor(length_px * dominant + 0.5)), 0)
    uv = start + np.arange(n)[:, None] * direction / dominant
    pixels = np.floor(uv + 0.5).astype(int)
    inside = ((pixels >= 0) & (pixels < [width, height])).all(axis=1)
    # The ray ends where it leaves the image.
    pixels = pixels[: n if inside.all() else int(np.argmin(inside))]
    counts = np.bincount(color_bins(color[pixels[:, 1], pixels[:, 0]]), minlength=4096)
    near = [margin_to_rounding(uv).min()] if n else []
    return counts, float(min([*near, margin_to_rounding(np.array(length_px * dominant))]))
