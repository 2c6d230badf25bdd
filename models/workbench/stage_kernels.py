"""Numba kernels of the stage: what moves laid over what stands, soft edges, bytes from light."""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

from snapfit.models.workbench.cover_kernels import MOVING, SHADOWED

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

_FAST = {"nogil": True, "cache": True, "error_model": "numpy", "fastmath": True}
_LEAST_LIGHT = 1e-4


@numba.njit(**_FAST)
def lay_over(
    standing: Singles, before: Singles, after: Singles, mark: Bytes, weight: float, out: Singles
) -> None:
    """Adds a picture in which something moves in front of one in which nothing does.

    Where the background is seen it is the standing picture, darkened as its light changes.

    Args:
        standing: (H, W, 3) linear light without what moves.
        before: (H, W, 3) the same, as one sample a pixel gives it.
        after: (H, W, 3) one sample a pixel, with what moves.
        mark: (H, W) of `cover_kernels`: what moves, its shadow, or neither.
        weight: share of the exposure.
        out: (H, W, 3) is added to.
    """
    for row in range(standing.shape[0]):
        for column in range(standing.shape[1]):
            kind = mark[row, column]
            for c in range(3):
                value = standing[row, column, c]
                if kind == MOVING:
                    value = after[row, column, c]
                elif kind == SHADOWED:
                    unshadowed = max(before[row, column, c], np.float32(_LEAST_LIGHT))
                    value *= min(after[row, column, c] / unshadowed, np.float32(1))
                out[row, column, c] += weight * value


@numba.njit(**_FAST)
def soften_edges(light: Singles, label: Bytes, out: Singles) -> None:
    """Smooths light (H, W, 3) with the weights 1 2 1 where labels (H, W) meet; copies the rest."""
    height, width = label.shape
    for row in range(height):
        for column in range(width):
            own = label[row, column]
            is_edge = (
                0 < row < height - 1
                and 0 < column < width - 1
                and (
                    label[row - 1, column] != own
                    or label[row + 1, column] != own
                    or label[row, column - 1] != own
                    or label[row, column + 1] != own
                )
            )
            for c in range(3):
                value = light[row, column, c]
                if is_edge:
                    value = np.float32(0.25) * value
                    for d in (-1, 1):
                        value += np.float32(0.125) * (
                            light[row + d, column, c] + light[row, column + d, c]
                        )
                        for e in (-1, 1):
                            value += np.float32(0.0625) * light[row + d, column + e, c]
                out[row, column, c] = value


@numba.njit(**_FAST)
def encoded(light: Singles, encoding: Bytes) -> Bytes:
    """Linear light (H, W, 3) as sRGB bytes by a table over equal steps of its square root."""
    out = np.empty(light.shape, dtype=np.uint8)
    last = len(encoding) - 1
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            for c in range(3):
                value = min(max(light[row, column, c], np.float32(0)), np.float32(1))
                out[row, column, c] = encoding[int(math.sqrt(value) * last + 0.5)]
    return out
