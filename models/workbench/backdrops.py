"""A stock of surfaces for the training images: made once from a seed, varied in each image.

A surface is a square picture with its smaller copies beside it (mip levels), so that far ground
neither flickers nor costs more. It goes on as its own mirror image beyond its borders.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.workbench import tables, texture

Bytes = npt.NDArray[np.uint8]
Rng = np.random.Generator

SIDE_PX = 768
N_LEVELS = 5
# Pixels a metre as they are painted; each image scales them anew.
PIXELS_PER_M = 1100.0
_SHAPE = (SIDE_PX, SIDE_PX)


class Kind(IntEnum):
    """What a surface is; the stock holds all kinds in this order, again and again."""

    WOOD = 0
    CLOTH = 1
    COATED = 2
    MAT = 3
    PAPER = 4
    PLAIN = 5
    CHECKS = 6
    STONE = 7
    STRIPES = 8
    HEAP = 9


N_KINDS = len(Kind)
_VARIANTS = 3


def stock_of_surfaces(rng: Rng) -> Bytes:
    """(N, S, 2 S, 3) uint8 sRGB, blue first: surfaces of all kinds with their mip levels."""
    painted = [paint(rng) for _ in range(_VARIANTS) for paint in _PAINTERS]
    return np.stack([_with_levels(surface) for surface in painted])


def _with_levels(surface: Bytes) -> Bytes:
    """Level l is 2**l times smaller and begins at column `level_column(l)`."""
    atlas = np.zeros((SIDE_PX, 2 * SIDE_PX, 3), np.uint8)
    level, column = surface, 0
    for _ in range(N_LEVELS):
        side = len(level)
        atlas[:side, column : column + side] = level
        column += side
        level = cv2.resize(level, (side // 2, side // 2), interpolation=cv2.INTER_AREA)
    return atlas


def _wood(rng: Rng) -> Bytes:
    return texture.wood(rng, _SHAPE, PIXELS_PER_M * rng.uniform(0.7, 1.5))


def _cloth(rng: Rng) -> Bytes:
    return tables.cloth(rng, _SHAPE, PIXELS_PER_M * rng.uniform(0.6, 1.6), _rgb(rng))


def _coated(rng: Rng) -> Bytes:
    return tables.coated(rng, _SHAPE, PIXELS_PER_M, _rgb(rng))


def _mat(rng: Rng) -> Bytes:
    return tables.cutting_mat(rng, _SHAPE, PIXELS_PER_M, _rgb(rng))


def _paper(rng: Rng) -> Bytes:
    return texture.paper(rng, _SHAPE)


def _plain(rng: Rng) -> Bytes:
    """Paint, metal or plastic: one colour, hardly mottled."""
    mottle = texture.smooth_noise(rng, _SHAPE, (rng.uniform(4, 200),) * 2)
    tone = 1 + rng.uniform(0.01, 0.05) * mottle + 0.012 * rng.standard_normal(_SHAPE)
    return _bytes(np.array(_rgb(rng), np.float32) * tone[..., None])


def _checks(rng: Rng) -> Bytes:
    """Tiles or a tablecloth."""
    cell = rng.uniform(14, 90)
    rows, columns = np.indices(_SHAPE) / cell
    odd = (np.floor(rows) + np.floor(columns)) % 2
    seam = np.minimum(np.abs(rows - np.round(rows)), np.abs(columns - np.round(columns)))
    one, other = np.array(_rgb(rng), np.float32), np.array(_rgb(rng), np.float32)
    tiles = np.where(odd[..., None] > 0, one, one + rng.uniform(0, 0.7) * (other - one))
    grout = np.exp(-((seam * cell / 1.5) ** 2)) * (rng.random() < 0.5)
    tone = 1 + 0.04 * texture.smooth_noise(rng, _SHAPE, (60, 60)) - 0.5 * grout
    return _bytes(tiles * tone[..., None])


def _stone(rng: Rng) -> Bytes:
    """Noise of all sizes between two colours: stone, carpet, concrete."""
    cell, total = rng.uniform(80, 300), np.zeros(_SHAPE, np.float32)
    roughness = rng.uniform(0.45, 0.9)
    for octave in range(7):
        size = max(cell / 2**octave, 1.0)
        total += roughness**octave * texture.smooth_noise(rng, _SHAPE, (size, size))
    share = 1 / (1 + np.exp(-rng.uniform(0.6, 2.5) * total))[..., None]
    one, other = np.array(_rgb(rng), np.float32), np.array(_rgb(rng), np.float32)
    return _bytes(one + share * rng.uniform(0.2, 1.0) * (other - one))


def _stripes(rng: Rng) -> Bytes:
    """A woven or printed pattern of stripes, bent a little."""
    angle, pitch = rng.uniform(0, math.pi), rng.uniform(8, 70)
    rows, columns = np.indices(_SHAPE).astype(np.float32)
    bend = rng.uniform(0, 12) * texture.smooth_noise(rng, _SHAPE, (150, 150))
    along = (rows * math.sin(angle) + columns * math.cos(angle) + bend) / pitch
    wave = np.tanh(rng.uniform(1, 6) * np.sin(2 * math.pi * along)) * 0.5 + 0.5
    one, other = np.array(_rgb(rng), np.float32), np.array(_rgb(rng), np.float32)
    grain = 1 + 0.03 * rng.standard_normal(_SHAPE)[..., None]
    return _bytes((one + wave[..., None] * (other - one)) * grain)


def _heap(rng: Rng) -> Bytes:
    """What a photograph of a full shelf or a cluttered room is made of: shapes on shapes."""
    picture = _stone(rng)
    n, largest = int(rng.integers(60, 220)), rng.uniform(0.1, 0.4) * SIDE_PX
    for i in range(n):
        size = largest * (1 - 0.8 * i / n) * rng.uniform(0.3, 1)
        center = rng.uniform(-0.05, 1.05, 2) * SIDE_PX
        color, kind = tuple(float(value) for value in _rgb(rng)), rng.random()
        if kind < 0.35:
            axes = (round(size / 2), round(size / 2 * rng.uniform(0.3, 1)))
            turn = rng.uniform(0, 180)
            at = (round(center[0]), round(center[1]))
            cv2.ellipse(picture, at, axes, turn, 0, 360, color, -1, cv2.LINE_AA)
        elif kind < 0.9:
            shape = (center, (size, size * rng.uniform(0.1, 1)), rng.uniform(0, 180))
            corners = cv2.boxPoints(shape).astype(np.int32)
            cv2.fillConvexPoly(picture, corners, color, cv2.LINE_AA)
        else:
            ends = np.round(center + rng.uniform(-size, size, (2, 2))).astype(int).tolist()
            thickness = int(rng.integers(1, 9))
            cv2.line(picture, ends[0], ends[1], color, thickness, cv2.LINE_AA)
    shading = 1 + 0.12 * texture.smooth_noise(rng, _SHAPE, (90, 90))
    blurred = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.6, 5.0))
    return _bytes(blurred * shading[..., None])


def _rgb(rng: Rng) -> tuple[int, int, int]:
    """A colour as things have it: mostly dull, seldom bright."""
    value = rng.uniform(0.1, 0.92)
    gray = np.full(3, value)
    vivid = rng.dirichlet((1, 1, 1)) * 3 * value
    color = gray + rng.beta(1.2, 3.0) * (vivid - gray)
    red, green, blue = (int(each) for each in np.clip(color * 255, 8, 247))
    return red, green, blue


def _bytes(picture: npt.NDArray[np.floating]) -> Bytes:
    rounded: Bytes = np.clip(picture, 0, 255).astype(np.uint8)
    return rounded


_PAINTERS: tuple[Callable[[Rng], Bytes], ...] = (
    *(_wood, _cloth, _coated, _mat, _paper, _plain, _checks, _stone, _stripes, _heap),
)
