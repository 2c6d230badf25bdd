"""A drawn scene with known poses: clamp parts before a noisy wall, flat-lit, with exact depth."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pytest

from snapfit.models.asset import Part, find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
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


def _colors(
    parts: Sequence[Part], part_id: npt.NDArray[np.uint8], light: npt.NDArray[np.float32]
) -> npt.NDArray[np.float32]:
    table = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in parts)], dtype=np.float32)
    colors: npt.NDArray[np.float32] = table[part_id] * (0.5 + 0.5 * np.abs(light))
    return colors


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
        rng = np.random.default_rng(5)
        seen = render(CAMERA.color, [(p.mesh, poses[p.name]) for p in parts], normals=True)
        assert seen.normal is not None
        wall = rng.integers(80, 150, (720, 1280, 3)).astype(np.float32)
        body = _colors(parts, seen.part_id, seen.normal[..., 2:]) + rng.normal(0, 4, (720, 1280, 1))
        color = np.where(seen.part_id[..., None] > 0, body, wall)
        depth_m = np.where(seen.depth > 0, seen.depth, WALL_M)
        if cover is not None:
            rows, columns, cover_m = cover
            color[rows, columns] = 200
            depth_m[rows, columns] = cover_m
        counts = np.round(depth_m * 1000).astype(np.uint16)
        if depth == "zero":
            counts[:] = 0
        return Frame(
            name,
            0,
            np.ascontiguousarray(np.clip(color, 0, 255).astype(np.uint8)),
            None if depth == "none" else counts,
        )

    return _draw
