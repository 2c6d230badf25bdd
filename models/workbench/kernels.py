"""Numba kernels of the workbench: light with soft shadows, pixels from samples, sensor noise.

Light is linear; points, normals and lights are in the colour camera's frame.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

SEARCH_TAPS, FILTER_TAPS = 14, 24
_SHADOW_BIAS_M = 0.0015
# A surface point is lifted by this along its normal before it looks for the lamp.
_LIFT_TEXELS = 1.8
_SAME_SURFACE_M = 0.003
# A blocker is looked for up to this share of the way from the surface to the light.
_SEARCH_SHARE = 0.12


@numba.njit(nogil=True, cache=True)
def share_lit(
    point: Floats,
    size_m: float,
    lens: Floats,
    shadow: Singles,
    cast: Bytes,
    slope: float,
    turn: Floats,
    taps: Floats,
) -> float:
    """Share of a lamp that a point sees: percentage-closer soft shadows (Fernando, 2005).

    Args:
        point: (3,) in the lamp's frame, m.
        size_m: diameter of the lamp.
        lens: (4,) fx, fy, cx, cy in px of the shadow map.
        shadow: (H, W) depth seen from the lamp, m; 0 is nothing.
        cast: (H, W) 0 where no blocker is in reach.
        slope: how much nearer to the lamp the surface itself comes, m per m to the side.
        turn: (2,) cosine and sine of the angle by which the taps are turned.
        taps: (search and filter taps, 2) offsets in a unit disc, the former first.
    """
    height, width = shadow.shape
    x, y, z = point[0], point[1], point[2]
    u, v = lens[0] * x / z + lens[2], lens[1] * y / z + lens[3]
    if not (0 <= u < width and 0 <= v < height) or cast[int(v), int(u)] == 0:
        return 1.0
    steep = slope * z / lens[0]
    radius = search_radius_px(size_m, lens[0] / z)
    total, n_blockers = 0.0, 0
    for i in range(SEARCH_TAPS):
        dx, dy = radius * taps[i, 0], radius * taps[i, 1]
        column, row = int(u + turn[0] * dx - turn[1] * dy), int(v + turn[1] * dx + turn[0] * dy)
        nearest = z - _SHADOW_BIAS_M - steep * (abs(dx) + abs(dy))
        if 0 <= row < height and 0 <= column < width and 0 < shadow[row, column] < nearest:
            total += shadow[row, column]
            n_blockers += 1
    if n_blockers == 0:
        return 1.0
    blocker = total / n_blockers
    radius = max(1.0, 0.5 * size_m * (z - blocker) / blocker * lens[0] / z)
    n_blocked = 0
    for i in range(SEARCH_TAPS, SEARCH_TAPS + FILTER_TAPS):
        dx, dy = radius * taps[i, 0], radius * taps[i, 1]
        column, row = int(u + turn[0] * dx - turn[1] * dy), int(v + turn[1] * dx + turn[0] * dy)
        nearest = z - _SHADOW_BIAS_M - steep * (abs(dx) + abs(dy))
        if 0 <= row < height and 0 <= column < width and 0 < shadow[row, column] < nearest:
            n_blocked += 1
    return 1 - n_blocked / FILTER_TAPS


@numba.njit(nogil=True, cache=True)
def search_radius_px(size_m: float, px_per_m: float) -> float:
    """How far around a point blockers are looked for in the shadow map of a lamp of this size."""
    return max(1.5, 0.5 * size_m * _SEARCH_SHARE / (1 - _SEARCH_SHARE) * px_per_m)


@numba.njit(nogil=True, cache=True)
def shadow_of(
    point: Floats,
    normal: Floats,
    lights: Floats,
    map_light: npt.NDArray[np.int64],
    light_from_camera: Floats,
    lenses: Floats,
    shadows: Singles,
    casts: Bytes,
    turn: Floats,
    taps: Floats,
    lit: Floats,
) -> None:
    """Lowers `lit` (L,) to the share of each lamp that a point sees; arguments as in `shade`."""
    place = np.empty(3)
    for m in range(len(map_light)):
        k = map_light[m]
        x, y, z = (lights[k, 0] - point[0], lights[k, 1] - point[1], lights[k, 2] - point[2])
        distance = math.sqrt(x * x + y * y + z * z)
        cosine = (normal[0] * x + normal[1] * y + normal[2] * z) / distance
        if cosine <= 0:
            lit[k] = 0.0
            continue
        lift_m = _LIFT_TEXELS * distance / lenses[m, 0]
        t = light_from_camera[m]
        for axis in range(3):
            place[axis] = t[axis, 3]
            for i in range(3):
                place[axis] += t[axis, i] * (point[i] + lift_m * normal[i])
        # Only steep faces need it; on the bench it would take the shadows of low things away.
        slope = min(max(math.sqrt(1 - cosine * cosine) / cosine - 1.0, 0.0), 4.0)
        share = share_lit(place, lights[k, 3], lenses[m], shadows[m], casts[m], slope, turn, taps)
        lit[k] = min(lit[k], share)


@numba.njit(nogil=True, cache=True)
def shade(
    depth: Singles,
    normal: Singles,
    albedo: Singles,
    gloss: Singles,
    intrinsics: Floats,
    origin: npt.NDArray[np.int64],
    up: Floats,
    ambient: Floats,
    lights: Floats,
    map_light: npt.NDArray[np.int64],
    light_from_camera: Floats,
    lenses: Floats,
    shadows: Singles,
    casts: Bytes,
    taps: Floats,
) -> Singles:
    """Lambert and Blinn-Phong under lights with soft shadows, and light from the whole sky.

    Args:
        depth: (H, W) m; 0 is nothing and stays black.
        normal: (H, W, 3) unit, to the camera's side.
        albedo: (H, W, 3) 0 to 1, linear.
        gloss: (H, W) strength of the highlight.
        intrinsics: (4,) fx, fy, cx, cy in px of this window.
        origin: (2,) column and row of the window in the whole picture.
        up: (3,) unit, away from the bench.
        ambient: (2, 3) light from above and from below.
        lights: (L, 7) position m, diameter m, intensity of three channels at 1 m.
        map_light: (M,) the light to which a shadow map belongs.
        light_from_camera: (M, 4, 4).
        lenses: (M, 4) fx, fy, cx, cy of the shadow maps.
        shadows: (M, H, W) m.
        casts: (M, H, W) 0 where no blocker is in reach.
        taps: as `share_lit` takes them.

    Returns:
        (H, W, 3) linear light.
    """
    height, width = depth.shape
    out = np.zeros((height, width, 3), dtype=np.float32)
    n_lights = lights.shape[0]
    point, n, turn = np.empty(3), np.empty(3), np.empty(2)
    # Shadows of the last even row and column: samples beside them on one surface take these over.
    lit = np.ones((width + 1, n_lights))
    for row in range(height):
        for column in range(width):
            z = depth[row, column]
            if z <= 0:
                continue
            point[0] = (column - intrinsics[2]) / intrinsics[0] * z
            point[1] = (row - intrinsics[3]) / intrinsics[1] * z
            point[2] = z
            n[0], n[1], n[2] = (
                normal[row, column, 0],
                normal[row, column, 1],
                normal[row, column, 2],
            )
            own, near_row, near_column = column, row & ~1, column & ~1
            z_near, n_near = depth[near_row, near_column], normal[near_row, near_column]
            alike = n[0] * n_near[0] + n[1] * n_near[1] + n[2] * n_near[2] > 0.98
            if (row | column) & 1 and alike and abs(z - z_near) < _SAME_SURFACE_M:
                own = near_column
            else:
                # Interleaved gradient noise (Jimenez, 2014) turns the taps from place to place.
                grain = 0.06711056 * (column + origin[0]) + 0.00583715 * (row + origin[1])
                angle = 2 * math.pi * ((52.9829189 * (grain % 1.0)) % 1.0)
                turn[0], turn[1] = math.cos(angle), math.sin(angle)
                own = column if not (row | column) & 1 else width
                lit[own] = 1.0
                shadow_of(
                    point,
                    n,
                    lights,
                    map_light,
                    light_from_camera,
                    lenses,
                    shadows,
                    casts,
                    turn,
                    taps,
                    lit[own],
                )
            upward = 0.5 + 0.5 * (n[0] * up[0] + n[1] * up[1] + n[2] * up[2])
            near = 1 / math.sqrt(point[0] * point[0] + point[1] * point[1] + z * z)
            vx, vy, vz = point[0] * near, point[1] * near, z * near
            for c in range(3):
                sky = ambient[0, c] * upward + ambient[1, c] * (1 - upward)
                out[row, column, c] = albedo[row, column, c] * sky
            for k in range(n_lights):
                if lit[own, k] <= 0:
                    continue
                lx, ly, lz = lights[k, 0] - point[0], lights[k, 1] - point[1], lights[k, 2] - z
                squared = lx * lx + ly * ly + lz * lz
                away = 1 / math.sqrt(squared)
                cosine = (n[0] * lx + n[1] * ly + n[2] * lz) * away
                if cosine <= 0:
                    continue
                strength = lit[own, k] * cosine / squared
                glint = 0.0
                if gloss[row, column] > 0:
                    hx, hy, hz = lx * away - vx, ly * away - vy, lz * away - vz
                    facing = max(n[0] * hx + n[1] * hy + n[2] * hz, 0.0)
                    # The highlight is the cosine of the half vector to the power of 24.
                    power = (facing * facing / (hx * hx + hy * hy + hz * hz)) ** 4
                    glint = gloss[row, column] * power * power * power
                for c in range(3):
                    light = strength * lights[k, 4 + c]
                    out[row, column, c] += light * (albedo[row, column, c] + glint)
    return out


@numba.njit(nogil=True, cache=True)
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


@numba.njit(nogil=True, cache=True)
def noisy_color(clean: Bytes, noise: npt.NDArray[np.int8], gain: Singles) -> Bytes:
    """Pixels (H, W, 3) with noise (H, W, 3) times a gain (256,) that depends on the brightness."""
    out = np.empty_like(clean)
    for row in range(clean.shape[0]):
        for column in range(clean.shape[1]):
            for c in range(3):
                value = clean[row, column, c]
                noisy = value + noise[row, column, c] * gain[value] + np.float32(0.5)
                out[row, column, c] = np.uint8(min(max(noisy, np.float32(0)), np.float32(255)))
    return out


@numba.njit(nogil=True, cache=True)
def noisy_depth(
    depth: Singles,
    nearest: Singles,
    farthest: Singles,
    bias: Singles,
    noise: Singles,
    chance: Singles,
    seen: npt.NDArray[np.bool_],
    step_m: float,
    hole_share: float,
    flying_share: float,
) -> npt.NDArray[np.uint16]:
    """What a time-of-flight camera would measure, millimetres; 0 is no measurement.

    Args:
        depth: (H, W) true depth, m.
        nearest: (H, W) least depth in the 3 x 3 neighbourhood, m.
        farthest: (H, W) largest depth there, m.
        bias: (H, W) systematic error, m.
        noise: (H, W) standard normal.
        chance: (H, W) uniform in 0 to 1.
        seen: (H, W) whether the depth camera looks there at all.
        step_m: a difference in the neighbourhood from which it is an edge, at 1 m; grows with the
            square of the depth.
        hole_share: share of edge pixels that measure nothing.
        flying_share: share of edge pixels that measure something between both sides.
    """
    height, width = depth.shape
    out = np.zeros((height, width), dtype=np.uint16)
    for row in range(height):
        for column in range(width):
            z = depth[row, column]
            if z <= 0 or not seen[row, column]:
                continue
            low, high = nearest[row, column], farthest[row, column]
            if high - low > step_m * (0.5 + z * z):
                u = chance[row, column]
                if u < hole_share:
                    continue
                if u < hole_share + flying_share:
                    z = low + (high - low) * (u - hole_share) / flying_share
            sigma = 0.0004 + 0.0014 * z * z
            measured = z + bias[row, column] + sigma * noise[row, column]
            out[row, column] = np.uint16(min(max(measured * 1000 + 0.5, 0.0), 65534.0))
    return out
