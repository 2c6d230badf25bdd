"""What a process makes once for all its training images: surfaces, foreign things, noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset, Part, bundled_names, find_asset
from snapfit.models.keypoints import surface_samples
from snapfit.models.mesh import Mesh, simplified
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.backdrops import SIDE_PX, stock_of_surfaces
from snapfit.models.workbench.distractors import distractor_meshes
from snapfit.models.workbench.scene import linear
from snapfit.models.workbench.train_modules import Module

_N_SHAPES, _POINTS, _MOST_FACES = 70, 350, 2500
_NOISE_PX, _NOISE_STEPS = 1536, 24.0


@dataclass(frozen=True, eq=False)
class Stock:
    """All that every image of a set is put together from.

    Attributes:
        surfaces: (N, S, 2 S, 3) of `stock_of_surfaces`.
        means: (N, 3) mean linear colour of each surface, blue first.
        things: foreign things, each a module of one part with its own colour.
        noise: (S, S, 3) int8, of a standard deviation of 24.
    """

    surfaces: npt.NDArray[np.uint8]
    means: Array
    things: tuple[Module, ...]
    noise: npt.NDArray[np.int8]


@lru_cache(maxsize=1)
def stock_for(asset: str, seed: int) -> Stock:
    """The stock for an asset (by its own name): parts of other assets are among the things."""
    rng = np.random.default_rng((seed, 0x570C))
    surfaces = stock_of_surfaces(rng)
    means = np.stack([linear(each[:SIDE_PX, :SIDE_PX]).mean(axis=(0, 1)) for each in surfaces])
    things = [_thing(Part("thing", mesh), rng) for mesh in distractor_meshes(_N_SHAPES, rng)]
    for name in bundled_names():
        if name != asset:
            things += _foreign(find_asset(name), rng)
    shape = (_NOISE_PX, _NOISE_PX, 3)
    grain = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (3, 3), 0.55)
    grain = np.rint(grain / grain.std() * _NOISE_STEPS)
    noise = np.clip(grain, -127, 127).astype(np.int8)
    return Stock(surfaces, means.astype(np.float64), tuple(things), noise)


def _foreign(asset: Asset, rng: np.random.Generator) -> list[Module]:
    things, seen = [], set()
    for part in asset.parts:
        if part.mesh.digest in seen:
            continue
        seen.add(part.mesh.digest)
        mesh = simplified(part.mesh, _MOST_FACES)
        centred = Mesh(mesh.vertices - mesh.center_m.astype(np.float32), mesh.faces)
        things.append(_thing(Part(part.name, centred, part.color_rgb), rng))
    return things


def _thing(part: Part, rng: np.random.Generator) -> Module:
    return Module(((part, Pose.identity()),), surface_samples(part.mesh, _POINTS, rng)[0])
