"""Another bench for each seed: what covers it, what lies on it, from where it is lit and seen."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.workbench import tables, texture
from snapfit.models.workbench.clutter import scattered
from snapfit.models.workbench.scene import (
    STANDARD_CAMERA,
    TEXELS_PER_M,
    Lamp,
    Scene,
    laid_on,
    looking_at,
    top_shape,
)
from snapfit.models.workbench.tables import Rgb

Bytes = npt.NDArray[np.uint8]


class Table(StrEnum):
    """What the bench's top is."""

    WOOD = "wood"
    CLOTH = "cloth"
    COATED = "coated"
    MAT = "mat"


# Shares of red, green and blue of the standard wood.
_WOODS = ((1.0, 1.0, 1.0), (0.74, 0.68, 0.62), (1.10, 1.12, 1.12), (0.98, 0.86, 0.78))
_COLORS: dict[Table, tuple[Rgb, ...]] = {
    Table.CLOTH: ((152, 142, 122), (92, 108, 130), (142, 88, 76), (108, 118, 96), (120, 104, 116)),
    Table.COATED: (
        (124, 134, 130),
        (98, 110, 124),
        (166, 156, 136),
        (86, 112, 94),
        (134, 118, 104),
    ),
    Table.MAT: ((34, 88, 74), (44, 60, 88), (84, 86, 92)),
}
_MAT_M = (0.60, 0.45)
_PAPER_M = (0.297, 0.21)
_EYE_M, _EYE_SPREAD_M = np.array([0.0, -0.365, 0.43]), np.array([0.055, 0.025, 0.025])
_TARGET_M, _TARGET_SPREAD_M = np.array([0.005, 0.01, 0.01]), np.array([0.012, 0.012, 0.004])


def table_of(seed: int) -> Table:
    """The kind of top; seeds that follow each other have all kinds in turn."""
    return list(Table)[seed % len(Table)]


def sampled_scene(seed: int, part_colors: Sequence[Rgb]) -> Scene:
    """A bench with its things, its lamps and a camera.

    Args:
        seed: of all of it.
        part_colors: sRGB, red first; the top is of a colour that stands out from them.
    """
    rng = np.random.default_rng((seed, 1))
    warm = 1 + rng.uniform(-0.06, 0.06) * np.array([1, 0, -1])
    side = float(rng.choice((-1, 1)))
    near = _lamp((0.60 * side, 0.05, 1.15), 0.16, (0.98, 1.10, 1.18), warm, rng)
    far = _lamp((-0.35 * side, 0.45, 1.55), 0.75, (0.78, 0.76, 0.72), 2 - warm, rng)
    eye = _EYE_M + _EYE_SPREAD_M * rng.uniform(-1, 1, 3)
    target = _TARGET_M + _TARGET_SPREAD_M * rng.uniform(-1, 1, 3)
    return Scene(
        camera=STANDARD_CAMERA,
        camera_from_world=looking_at(_triple(eye), _triple(target)),
        lamps=(near, far),
        ambient=np.array([[0.25, 0.24, 0.225], [0.08, 0.10, 0.115]]) * warm,
        items=scattered(rng),
        ground=_ground(rng, seed, part_colors),
    )


def _lamp(
    place_m: tuple[float, float, float],
    diameter_m: float,
    light: tuple[float, float, float],
    warm: npt.NDArray[np.float64],
    rng: np.random.Generator,
) -> Lamp:
    moved = np.array(place_m) + rng.uniform(-0.1, 0.1, 3)
    bright = np.array(light) * warm * rng.uniform(0.92, 1.06)
    return Lamp(_triple(moved), diameter_m, _triple(bright))


def _ground(rng: np.random.Generator, seed: int, part_colors: Sequence[Rgb]) -> Bytes:
    shape, table = top_shape(), table_of(seed)
    if table is Table.CLOTH:
        color = _apart(_COLORS[table], part_colors, rng)
        top = tables.cloth(rng, shape, TEXELS_PER_M, color)
    elif table is Table.COATED:
        color = _apart(_COLORS[table], part_colors, rng)
        top = tables.coated(rng, shape, TEXELS_PER_M, color)
    else:
        tint = np.array(_WOODS[seed // len(Table) % len(_WOODS)][::-1])
        wood = texture.wood(rng, shape, TEXELS_PER_M) * tint
        top = np.clip(wood, 0, 255).astype(np.uint8)
    if table is Table.MAT:
        color = _apart(_COLORS[table], part_colors, rng)
        mat = tables.cutting_mat(rng, _texels(_MAT_M), TEXELS_PER_M, color)
        laid_on(top, mat, (rng.uniform(-0.02, 0.04), 0.03), rng.uniform(-5, 5))
    side = float(rng.choice((-1, 1)))
    page = texture.paper(rng, _texels(_PAPER_M))
    place = side * rng.uniform(0.19, 0.27), rng.uniform(0.14, 0.20)
    laid_on(top, page, place, rng.uniform(-25, 25))
    return top


def _apart(choices: Sequence[Rgb], others: Sequence[Rgb], rng: np.random.Generator) -> Rgb:
    """One of those two colours that look least like any of the others."""
    own, parts = _lab(choices), _lab(others)
    distance = np.linalg.norm(own[:, None] - parts[None], axis=-1).min(axis=1)
    best = np.argsort(-distance)[:2]
    return choices[int(rng.choice(best))]


def _lab(colors: Sequence[Rgb]) -> npt.NDArray[np.float32]:
    """(N, 3) CIE L*a*b*."""
    pixels = np.array(colors, dtype=np.float32)[None] / 255
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2Lab)[0], dtype=np.float32)


def _texels(size_m: tuple[float, float]) -> tuple[int, int]:
    """Rows and columns of a sheet, given by its width and height."""
    return round(size_m[1] * TEXELS_PER_M), round(size_m[0] * TEXELS_PER_M)


def _triple(values: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
