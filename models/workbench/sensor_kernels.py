"""Numba kernels of the workbench's camera: noise, and what goes wrong at depth edges."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


@numba.njit(nogil=True, cache=True, error_model="numpy")
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


@numba.njit(nogil=True, cache=True, error_model="numpy")
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
