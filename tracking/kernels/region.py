"""The region modality's correspondences (Stoiber et al., SRT3D, IJCV 2022).

A correspondence line runs across the projected contour. Its pixels' colour posteriors are
multiplied in segments; smoothed step functions turn them into a discrete posterior over the
contour's offset along the line.
"""

from __future__ import annotations

import math

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
    U8,
    VALID,
    Bodies,
    Cameras,
    Images,
    Lines,
    OcclusionSettings,
    RegionSettings,
)

_TAPS = 8
_BINS = 12
_SEGMENTS = _TAPS + _BINS - 1
_BEYOND_PX = (5.0, 9.0)
"""Where the neighbour of a contour point is looked for; a pixel of the small rendering is 4."""


@njit(cache=True, nogil=True, fastmath=FAST)
def find_lines(
    body: int,
    first: int,
    last: int,
    iteration: int,
    images: Images,
    cameras: Cameras,
    bodies: Bodies,
    contour: I16,
    unit: np.float32,
    settings: RegionSettings,
    occlusion: OcclusionSettings,
    lines: Lines,
    counts: I64,
    scratch: F32,
) -> None:
    """Correspondence lines first..last of a body, for one iteration.

    Args:
        body: index of the body.
        first, last: range of the contour points, last excluded.
        iteration: correspondence iteration, selects scale and threshold.
        images, cameras: what is seen.
        bodies: poses and colour tables are read.
        contour: (N, 9) the view's contour points; see `ViewpointModel.contour`.
        unit: metres a count of `contour`.
        settings, occlusion: parameters.
        lines: written.
        counts: (4,) written: considered, occluded, valid lines of this range.
        scratch: (19,) room for the segments' probabilities.
    """
    pose, depth_pose = bodies.color_poses[body], bodies.depth_poses[body]
    camera = intrinsics(cameras.color)
    scale = settings.scales[iteration]
    # Rows of arrays are taken once, out of the loop: each costs a counted reference.
    table = bodies.tables[body]
    point_of, place_of, valid_of = lines.point[body], lines.place[body], lines.valid[body]
    posterior_of, moments_of = lines.posterior[body], lines.moments[body]
    for i in range(first, last):
        valid_of[i] = 0
        px, py, pz = contour[i, 0] * unit, contour[i, 1] * unit, contour[i, 2] * unit
        x, y, z = transform(pose, px, py, pz)
        if z <= 0.0:
            continue
        px_per_m = camera.fx / z
        u, v = px_per_m * x + camera.cx, camera.fy * y / z + camera.cy
        if not (0.0 <= u < camera.width - 1 and 0.0 <= v < camera.height - 1):
            continue
        foreground = contour[i, 6] * unit * px_per_m
        background = contour[i, 7] * unit * px_per_m
        if min(foreground, background) < settings.min_continuous * scale:
            continue
        counts[CONSIDERED] += 1
        dx, dy, dz = transform(depth_pose, px, py, pz)
        offset = contour[i, 8] * unit
        if hidden(body, images, cameras, dx, dy, dz, offset, u, v, z, occlusion):
            counts[OCCLUDED] += 1
            continue
        bx = contour[i, 3] * NORMAL_UNIT
        by = contour[i, 4] * NORMAL_UNIT
        bz = contour[i, 5] * NORMAL_UNIT
        nx, ny, _ = rotate(pose, bx, by, bz)
        length = math.sqrt(nx * nx + ny * ny)
        if length < 1e-3:
            continue
        if images.neighboured[body] and runs_into_alike(
            body, images, u, v, nx / length, ny / length, occlusion.image_scale
        ):
            counts[OCCLUDED] += 1
            continue
        place_of[i, 0], place_of[i, 1] = u, v
        place_of[i, 2], place_of[i, 3] = nx / length, ny / length
        place_of[i, 6], place_of[i, 7] = foreground, background
        if not segment_probabilities(images.color, table, scale, place_of, i, scratch):
            continue
        posterior(scratch, settings.step_foreground, posterior_of, i)
        moments(posterior_of, i, settings.min_variance, moments_of)
        point_of[i, 0], point_of[i, 1], point_of[i, 2] = px, py, pz
        valid_of[i] = 1
        counts[VALID] += 1


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def runs_into_alike(
    body: int,
    images: Images,
    u: np.float32,
    v: np.float32,
    nu: np.float32,
    nv: np.float32,
    image_scale: np.float32,
) -> bool:
    """Whether a body of the same colour lies just beyond a contour point: no edge is seen there.

    Args:
        body: index of the body.
        images: the small rendering, and which bodies are alike.
        u, v: the contour point, px.
        nu, nv: unit normal, from the body outwards.
        image_scale: size of the small rendering, in colour image sizes.
    """
    height, width = images.near_id.shape
    for reach_px in _BEYOND_PX:
        column = int((u + reach_px * nu + 0.5) * image_scale)
        row = int((v + reach_px * nv + 0.5) * image_scale)
        if 0 <= column < width and 0 <= row < height:
            other = images.near_id[row, column]
            if other != 0 and images.alike[body, other - 1]:
                return True
    return False


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def segment_probabilities(
    color: U8, table: F32, scale: int, places: F32, line: int, segments: F32
) -> bool:
    """Multiply the pixels' posteriors in segments of `scale` px along the dominant image axis.

    Args:
        color: (H, W, 3) BGR.
        table: (4096,) posterior of the foreground, by colour (4 bits a channel).
        scale: pixels of a segment.
        places: (N, 8) of this line, centre and normal are read; offset of the pixel grid and
            segments per px along the normal are written.
        line: row of `places`.
        segments: (19,) written: the foreground's share, from the inside of the body outwards.

    Returns:
        False where the line leaves the image.
    """
    height, width = color.shape[0], color.shape[1]
    u, v = places[line, 0], places[line, 1]
    nu, nv = places[line, 2], places[line, 3]
    horizontal = abs(nu) >= abs(nv)
    dominant = abs(nu) if horizontal else abs(nv)
    center = u if horizontal else v
    half = np.float32(0.5) * (_SEGMENTS * scale - 1)
    sign = 1 if (nu if horizontal else nv) > 0.0 else -1
    # The innermost pixel, on the grid of the dominant axis; the rest follows along the normal.
    start = math.floor(center - sign * half + np.float32(0.5))
    delta = start + sign * half - center
    slope = (nv if horizontal else nu) / dominant
    minor = (v if horizontal else u) + slope * sign * (start - center) + np.float32(0.5)
    end = start + sign * (_SEGMENTS * scale - 1)
    minor_end = minor + slope * (_SEGMENTS * scale - 1)
    major_size = width if horizontal else height
    minor_size = height if horizontal else width
    if min(start, end) < 0 or max(start, end) >= major_size:
        return False
    if min(minor, minor_end) < 0.5 or max(minor, minor_end) >= minor_size - 0.5:
        return False
    places[line, 4] = delta * sign / dominant
    places[line, 5] = dominant / scale

    step_u = np.float32(sign) if horizontal else slope
    step_v = slope if horizontal else np.float32(sign)
    at_u = np.float32(start + 0.5) if horizontal else minor
    at_v = minor if horizontal else np.float32(start + 0.5)
    for s in range(_SEGMENTS):
        foreground = np.float32(1.0)
        background = np.float32(1.0)
        for _ in range(scale):
            row, column = int(at_v), int(at_u)
            p = table[
                (int(color[row, column, 0]) >> 4 << 8)
                | (int(color[row, column, 1]) >> 4 << 4)
                | (int(color[row, column, 2]) >> 4)
            ]
            foreground *= p
            background *= np.float32(1.0) - p
            at_u += step_u
            at_v += step_v
        total = foreground + background
        if total > 0.0:
            segments[s] = foreground / total
        else:
            segments[s] = np.float32(0.5)
    return True


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def posterior(segments: F32, step_foreground: F32, out: F32, line: int) -> None:
    """The posterior over the contour's offset (SRT3D): product over the taps.

    Args:
        segments: (19,) the foreground's share; the background has the rest.
        step_foreground: (8,) smoothed step function of the foreground.
        out: (N, 12) written; each row sums to one.
        line: row of `out`.
    """
    area = np.float32(0.0)
    for d in range(_BINS):
        product = np.float32(1.0)
        for k in range(_TAPS):
            # f h + (1 - f) (1 - h), the segment's share of foreground f and the step h
            h = step_foreground[k]
            product *= (np.float32(1.0) - h) + segments[d + k] * (h + h - np.float32(1.0))
        out[line, d] = product
        area += product
    inverse = np.float32(1.0) / area
    for d in range(_BINS):
        out[line, d] *= inverse


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def moments(distributions: F32, line: int, min_variance: np.float32, out: F32) -> None:
    """Mean (from the line's centre) and variance of a posterior, segments.

    Args:
        distributions: (N, 12) posteriors.
        line: row of `distributions` and `out`.
        min_variance: the smallest variance, segments squared.
        out: (N, 2) written.
    """
    mean = np.float32(0.0)
    for d in range(_BINS):
        mean += d * distributions[line, d]
    variance = np.float32(0.0)
    for d in range(_BINS):
        variance += (d - mean) * (d - mean) * distributions[line, d]
    out[line, 0] = mean - np.float32(0.5 * (_BINS - 1))
    out[line, 1] = max(variance, min_variance)
