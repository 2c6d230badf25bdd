"""Tops of a bench that are not bare wood: woven cloth, matt paint, a printed cutting mat.

All give (H, W, 3) uint8 sRGB, blue first, from a seed; colours are sRGB, 0 to 255, red first.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from snapfit.models.workbench.texture import Bytes, Singles, smooth_noise

Rgb = tuple[int, int, int]

_THREAD_MM = 2.6
_GRID_MM, _MAJOR = 10.0, 5


def cloth(
    rng: np.random.Generator, shape: tuple[int, int], pixels_per_m: float, color_rgb: Rgb
) -> Bytes:
    """Coarse linen: warp and weft, each thread of its own tone, pressed folds and soft waves."""
    mm = pixels_per_m / 1000
    rows = np.arange(shape[0], dtype=np.float32)[:, None] / (_THREAD_MM * mm)
    columns = np.arange(shape[1], dtype=np.float32)[None] / (_THREAD_MM * mm)
    rows = rows + 0.5 * smooth_noise(rng, shape, (90 * mm, 90 * mm))
    columns = columns + 0.5 * smooth_noise(rng, shape, (90 * mm, 90 * mm))
    weft, warp = np.floor(rows).astype(np.int64), np.floor(columns).astype(np.int64)
    tones = 0.045 * rng.standard_normal((2, 4096)).astype(np.float32)
    over = (weft + warp) % 2 == 0
    thread = np.where(over, tones[0][weft % 4096], tones[1][warp % 4096])
    # A thread is round: darkest where it dives under the other.
    along = np.where(over, columns - warp, rows - weft)
    across = np.where(over, rows - weft, columns - warp)
    relief = np.sin(math.pi * along) * np.sin(math.pi * across)
    slubs = np.maximum(smooth_noise(rng, shape, (2 * mm, 38 * mm)) - 1.5, 0)
    slubs -= np.maximum(smooth_noise(rng, shape, (38 * mm, 2 * mm)) - 1.5, 0)
    tone = 0.86 + 0.16 * relief + thread + 0.05 * slubs
    tone *= _folds(rng, shape, mm)
    stripe = _stripes(rng, weft, warp)
    color = np.array(color_rgb[::-1], np.float32)
    light = 0.45 * color + 0.55 * np.array([206, 214, 218], np.float32)
    painted = (color + stripe[..., None] * (light - color)) * tone[..., None]
    woven: Bytes = np.clip(painted, 0, 255).astype(np.uint8)
    return woven


def _folds(rng: np.random.Generator, shape: tuple[int, int], mm: float) -> Singles:
    """(H, W) how light falls on a cloth that was folded in four and does not lie quite flat."""
    waves = 0.045 * smooth_noise(rng, shape, (150 * mm, 210 * mm))
    shade = 1 + waves
    for axis in (0, 1):
        across = np.arange(shape[axis], dtype=np.float32) / mm
        middle = shape[axis] / mm / 2 + rng.uniform(-60, 60)
        for crease in (middle - 290, middle, middle + 290):
            bent = 5 * smooth_noise(rng, (shape[1 - axis], 1), (160 * mm, 1))[:, 0]
            off = (across[:, None] if axis == 0 else across[None]) - crease
            off = off - (bent[None] if axis == 0 else bent[:, None])
            # One side of the ridge faces the lamp, the other turns away from it.
            shade += 0.11 * off / 7 * np.exp(0.5 - (off / 7) ** 2 / 2) * rng.choice((-1, 1))
            shade -= 0.05 * np.exp(-((off / 1.6) ** 2))
    lit: Singles = shade.astype(np.float32)
    return lit


def _stripes(rng: np.random.Generator, weft: np.ndarray, warp: np.ndarray) -> Singles:
    """(H, W) 0 to 1: a check of paler threads, as on a kitchen cloth."""
    period, width = int(rng.integers(34, 46)), int(rng.integers(3, 6))
    offset = rng.integers(0, period, 2)
    share = np.zeros(weft.shape, np.float32)
    for threads, first in ((weft, offset[0]), (warp, offset[1])):
        place = (threads + int(first)) % period
        share += 0.5 * ((place < width) | ((place >= width + 3) & (place < width + 4)))
    return share


def coated(
    rng: np.random.Generator, shape: tuple[int, int], pixels_per_m: float, color_rgb: Rgb
) -> Bytes:
    """A painted top in use: mottled, speckled, scratched, with smears and drips of glue."""
    mm = pixels_per_m / 1000
    tone = 1 + 0.022 * smooth_noise(rng, shape, (240 * mm, 300 * mm))
    tone += 0.009 * smooth_noise(rng, shape, (26 * mm, 40 * mm))
    tone += 0.022 * rng.standard_normal(shape, dtype=np.float32)
    wiped = np.maximum(smooth_noise(rng, shape, (14 * mm, 180 * mm)) - 0.9, 0)
    tone += 0.035 * wiped
    worn = np.maximum(smooth_noise(rng, shape, (70 * mm, 90 * mm)) - 1.3, 0)
    tone -= 0.06 * worn
    tone += 0.0016 * _marks(rng, shape, mm, 130, (8, 150))
    speckle = smooth_noise(rng, shape, (1.6 * mm, 1.6 * mm))
    tone += 0.10 * (speckle > 2.6) - 0.12 * (speckle < -2.5)
    painted = np.array(color_rgb[::-1], np.float32) * tone[..., None]
    for _ in range(int(rng.integers(9, 15))):
        center = (int(rng.integers(shape[1])), int(rng.integers(shape[0])))
        axes = (round(rng.uniform(1, 5) * mm), round(rng.uniform(1, 4) * mm))
        splash = tuple(float(value) for value in rng.uniform(70, 215) + rng.uniform(-20, 20, 3))
        cv2.ellipse(painted, center, axes, rng.uniform(0, 180), 0, 360, splash, -1, cv2.LINE_AA)
    top: Bytes = np.clip(painted, 0, 255).astype(np.uint8)
    return top


def cutting_mat(
    rng: np.random.Generator, shape: tuple[int, int], pixels_per_m: float, color_rgb: Rgb
) -> Bytes:
    """A mat with a printed grid of centimetres and numbers, cut up by use."""
    mm = pixels_per_m / 1000
    mat = np.empty((*shape, 3), np.uint8)
    mat[:] = color_rgb[::-1]
    print_bgr = tuple(min(int(0.55 * value + 92), 255) for value in color_rgb[::-1])
    height_mm, width_mm = shape[0] / mm, shape[1] / mm
    margin = 15.0
    for axis, length_mm, other_mm in ((0, width_mm, height_mm), (1, height_mm, width_mm)):
        n = int((length_mm - 2 * margin) // _GRID_MM)
        last_mm = margin + int((other_mm - 2 * margin) // _GRID_MM) * _GRID_MM
        for i in range(n + 1):
            at = round((margin + i * _GRID_MM) * mm)
            ends = round(margin * mm), round(last_mm * mm)
            a, b = ((at, ends[0]), (at, ends[1])) if axis == 0 else ((ends[0], at), (ends[1], at))
            cv2.line(mat, a, b, print_bgr, 2 if i % _MAJOR == 0 else 1)
            if i % _MAJOR == 0:
                place = (at - round(3 * mm), round(12 * mm))
                place = place if axis == 0 else (round(4 * mm), at + round(3 * mm))
                cv2.putText(mat, str(i), place, 0, 0.34 * mm, print_bgr, 1, cv2.LINE_AA)
    tone = 1 + 0.035 * smooth_noise(rng, shape, (60 * mm, 80 * mm))
    tone += 0.025 * rng.standard_normal(shape, dtype=np.float32)
    tone -= 0.0014 * np.abs(_marks(rng, shape, mm, 60, (20, 220)))
    worn: Bytes = np.clip(mat * tone[..., None], 0, 255).astype(np.uint8)
    return worn


def _marks(
    rng: np.random.Generator,
    shape: tuple[int, int],
    mm: float,
    n: int,
    length_mm: tuple[float, float],
) -> Singles:
    """(H, W) scratches, -150 to 150."""
    marks = np.zeros(shape, np.float32)
    for _ in range(n):
        x, y = rng.uniform(0, shape[1]), rng.uniform(0, shape[0])
        angle, length = rng.uniform(0, math.pi), rng.uniform(*length_mm) * mm
        end = (round(x + length * math.cos(angle)), round(y + length * math.sin(angle)))
        strength = float(rng.uniform(40, 150) * rng.choice((-1, 1)))
        cv2.line(marks, (round(x), round(y)), end, strength, 1, cv2.LINE_AA)
    return marks
