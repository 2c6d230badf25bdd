"""Procedural surfaces, all from a seed: planks of wood, a printed sheet of paper."""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import numpy as np
import numpy.typing as npt

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

_STRIP_ROWS = 32


def smooth_noise(
    rng: np.random.Generator, shape: tuple[int, int], cell: tuple[float, float]
) -> Singles:
    """(H, W) noise of about unit variance that varies over `cell` (rows, columns) pixels."""
    rows, columns = (max(2, math.ceil(n / c) + 3) for n, c in zip(shape, cell, strict=True))
    coarse = rng.standard_normal((rows, columns), dtype=np.float32)
    grown = cv2.resize(
        coarse,
        (math.ceil(columns * cell[1]), math.ceil(rows * cell[0])),
        interpolation=cv2.INTER_CUBIC,
    )
    noise: Singles = grown[: shape[0], : shape[1]]
    return noise


def wood(rng: np.random.Generator, shape: tuple[int, int], pixels_per_m: float) -> Bytes:
    """(H, W, 3) uint8 sRGB, blue first: boards along the columns, with grain, pores and seams."""
    height = shape[0]
    mm = pixels_per_m / 1000
    board = rng.integers(0, 1 << 16)
    wave = smooth_noise(rng, shape, (60 * mm, 420 * mm))
    ripple = smooth_noise(rng, shape, (22 * mm, 300 * mm))
    fibre = smooth_noise(rng, shape, (1.2 * mm, 46 * mm))
    coarse = smooth_noise(rng, shape, (7 * mm, 160 * mm))
    speck = smooth_noise(rng, shape, (0.9 * mm, 9 * mm))
    blot = smooth_noise(rng, shape, (130 * mm, 130 * mm))
    tints = 0.10 * np.random.default_rng(int(board)).standard_normal(64).astype(np.float32)
    tone = np.empty(shape)
    for strip in _strips(height):
        rows = np.arange(strip.start, strip.stop, dtype=np.float32)[:, None]
        index = np.floor(rows / (118 * mm)).astype(np.int64) + int(board) % 7
        across = rows / mm + 9 * wave[strip] + 53.0 * index
        rings = np.sin(across * 0.33 + 2.2 * ripple[strip])
        pores = np.maximum(speck[strip] - 1.35, 0)
        shade = 0.5 + 0.10 * rings + 0.055 * fibre[strip] + 0.08 * coarse[strip] - 0.16 * pores
        shade += tints[index % 64]
        seam = np.abs(rows / (118 * mm) - np.round(rows / (118 * mm))) * 118
        shade = shade * (1 - 0.55 * np.exp(-((seam / 0.9) ** 2))).astype(np.float32)
        tone[strip] = shade - 0.10 * np.maximum(blot[strip] - 1.1, 0)
    _scratch(rng, tone, mm)
    return _painted(tone)


def _painted(tone: npt.NDArray[np.float64]) -> Bytes:
    """(H, W, 3) uint8: from dark to light wood."""
    dark, light = np.array([52, 78, 104], np.float32), np.array([140, 172, 198], np.float32)
    painted = np.empty((*tone.shape, 3), np.uint8)
    for strip in _strips(len(tone)):
        painted[strip] = dark + (light - dark) * np.clip(tone[strip], 0, 1)[..., None]
    return painted


def _strips(height: int) -> Iterator[slice]:
    """Of so many rows that what is computed in between stays in the processor's cache."""
    for start in range(0, height, _STRIP_ROWS):
        yield slice(start, min(start + _STRIP_ROWS, height))


def _scratch(rng: np.random.Generator, tone: npt.NDArray[np.float64], mm: float) -> None:
    """Scratches and saw marks, in place."""
    height, width = tone.shape
    marks = np.zeros(tone.shape, np.uint8)
    for _ in range(70):
        x, y = rng.uniform(0, width), rng.uniform(0, height)
        angle, length = rng.uniform(0, math.pi), rng.uniform(10, 120) * mm
        end = (round(x + length * math.cos(angle)), round(y + length * math.sin(angle)))
        cv2.line(marks, (round(x), round(y)), end, int(rng.integers(40, 150)), 1, cv2.LINE_AA)
    sign = np.where(smooth_noise(rng, (height, width), (200, 200)) > 0, 1.0, -1.0)
    tone += (0.0016 * marks * sign).astype(np.float32)


def paper(rng: np.random.Generator, shape: tuple[int, int]) -> Bytes:
    """(H, W, 3) uint8 sRGB, blue first: a printed drawing of a part, with dimensions and text."""
    height, width = shape
    page = np.full((height, width, 3), (206, 214, 218), np.uint8)
    ink, scale = (70, 62, 60), height / 300
    cv2.rectangle(
        page, _at(12, 12, scale), _at(width / scale - 12, 288, scale), ink, 1, cv2.LINE_AA
    )
    for left, top, size in ((30, 40, 90), (150, 60, 46), (40, 170, 60)):
        corner = _at(left + 1.6 * size, top + size, scale)
        cv2.rectangle(page, _at(left, top, scale), corner, ink, 1, cv2.LINE_AA)
        middle = _at(left + 0.5 * size, top + 0.5 * size, scale)
        cv2.circle(page, middle, round(size * 0.3 * scale), ink, 1, cv2.LINE_AA)
        ends = _at(left, top - 8, scale), _at(left + 1.6 * size, top - 8, scale)
        cv2.line(page, *ends, ink, 1, cv2.LINE_AA)
    for line in range(16):
        top = 165 + 7 * line
        length = rng.uniform(30, 55)
        cv2.line(page, _at(148, top, scale), _at(148 + length, top, scale), ink, 1, cv2.LINE_AA)
    shading = 2.5 * smooth_noise(rng, shape, (height / 3, width / 3))
    shaded: Bytes = np.clip(page + shading[..., None], 0, 255).astype(np.uint8)
    return shaded


def _at(x: float, y: float, scale: float) -> tuple[int, int]:
    return round(x * scale), round(y * scale)
