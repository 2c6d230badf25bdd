"""A drawn scene with known poses: clamp parts before a noisy wall, flat-lit, with exact depth."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest

from snapfit.models.asset import Part, find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import Rendering, render
from snapfit.tracking.frame import Frame

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
WALL_M = 1.2

Draw = Callable[..., Frame]


@pytest.fixture(scope="session")
def camera() -> RgbdCamera:
    return CAMERA


@pytest.fixture(scope="session")
def clamp() -> tuple[Part, ...]:
    return find_asset("hobby-corner-clamp").tracked_parts


@cache
def _wall_and_noise() -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float64]]:
    """The same in each frame, so that only the parts are drawn anew."""
    rng = np.random.default_rng(5)
    wall = rng.integers(80, 150, (720, 1280, 3)).astype(np.uint8)
    return wall, rng.normal(0, 4, (720, 1280, 1))


def _color(parts: Sequence[Part], seen: Rendering) -> npt.NDArray[np.uint8]:
    """The parts, lit from the camera, before the wall."""
    assert seen.normal is not None
    wall, noise = _wall_and_noise()
    table = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in parts)], dtype=np.float32)
    shown = seen.part_id > 0
    light = 0.5 + 0.5 * np.abs(seen.normal[shown][:, 2:])
    color = wall.copy()
    color[shown] = np.clip(table[seen.part_id[shown]] * light + noise[shown], 0, 255)
    return color


@pytest.fixture(scope="session")
def draw() -> Draw:
    """draw(parts, {name: pose}, depth="exact"|"zero"|"none", cover=None): a frame.

    `cover` = (rows, columns, depth_m): a grey board in front of that part of the image.
    """

    def _draw(
        parts: Sequence[Part],
        poses: Mapping[str, Pose],
        *,
        depth: str = "exact",
        cover: tuple[slice, slice, float] | None = None,
        name: str = "0",
    ) -> Frame:
        seen = render(CAMERA.color, [(p.mesh, poses[p.name]) for p in parts], normals=True)
        color = _color(parts, seen)
        depth_m = np.where(seen.depth > 0, seen.depth, WALL_M)
        if cover is not None:
            rows, columns, cover_m = cover
            color[rows, columns] = 200
            depth_m[rows, columns] = cover_m
        counts = np.round(depth_m * 1000).astype(np.uint16)
        if depth == "zero":
            counts[:] = 0
        return Frame(name, 0, color, None if depth == "none" else counts)

    return _draw
