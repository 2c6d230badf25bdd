"""A drawn bench with parts on it, whose poses are known."""

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from bench import CAMERA, NORMAL, OFFSET_M, on_bench

from snapfit.models.asset import Part, find_asset
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.body import Body, load_bodies
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.frame import Frame

Draw = Callable[..., Frame]


@pytest.fixture(scope="session")
def needs_open3d() -> None:
    try:
        open3d()
    except TrackingError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def camera() -> RgbdCamera:
    return CAMERA


@pytest.fixture(scope="session")
def clamp() -> tuple[Part, ...]:
    return find_asset("hobby-corner-clamp").tracked_parts


@pytest.fixture(scope="session")
def bodies(clamp: tuple[Part, ...]) -> tuple[Body, ...]:
    return load_bodies(clamp)


@pytest.fixture(scope="session")
def lying(clamp: tuple[Part, ...]) -> dict[str, Pose]:
    """Poses of the parts, each on the bench and apart from the others."""
    base, jaw, bolt = clamp
    return {
        base.name: on_bench(base, [1.2, 0.1, 0.3], -0.15, 0.03),
        jaw.name: on_bench(jaw, [2.0, 0.5, -0.2], 0.04, 0.06),
        bolt.name: on_bench(bolt, [0.3, 0.8, 1.1], 0.17, -0.02),
    }


@pytest.fixture(scope="session")
def draw() -> Draw:
    """draw(parts, {name: pose}, bench=True, camera=CAMERA): a frame; without a bench no depth."""

    def _draw(
        parts: Sequence[Part],
        poses: Mapping[str, Pose],
        *,
        bench: bool = True,
        camera: RgbdCamera = CAMERA,
    ) -> Frame:
        drawn = [part for part in parts if part.name in poses]
        seen = render(camera.color, [(p.mesh, poses[p.name]) for p in drawn], normals=True)
        assert seen.normal is not None
        table = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in drawn)])
        shade = 0.5 + 0.5 * np.abs(seen.normal[..., 2:])
        assert camera.depth is not None
        noise, ground, depth_noise = _chance(seen.depth.shape, _shape(camera.depth))
        shown = seen.part_id > 0
        color = ground.copy()
        color[shown] = np.clip(table[seen.part_id[shown]] * shade[shown] + noise[shown], 0, 255)
        depth_from_color = camera.color_from_depth.inverse()
        bodies = [(p.mesh, depth_from_color @ poses[p.name]) for p in drawn]
        depth_m = render(camera.depth, bodies).depth.astype(np.float64)
        if bench:
            depth_m = np.where(depth_m > 0, depth_m, _bench_m(camera.depth, camera))
        depth_m += (depth_m > 0) * depth_noise
        counts = np.round(depth_m / camera.depth_scale_m).astype(np.uint16)
        return Frame("0", 0, color, counts)

    return _draw


def _shape(camera: PinholeCamera) -> tuple[int, int]:
    return camera.height, camera.width


@cache
def _chance(
    shape: tuple[int, int], depth_shape: tuple[int, int]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint8], npt.NDArray[np.float64]]:
    """Noise of the parts, the bench's colour, noise of the depth: the same in each frame."""
    rng = np.random.default_rng(3)
    noise = rng.normal(0, 4, (*shape, 1))
    ground = np.repeat(rng.integers(70, 110, (*shape, 1)), 3, axis=2).astype(np.uint8)
    return noise, ground, rng.normal(0, 0.0007, depth_shape)


def _bench_m(depth: PinholeCamera, camera: RgbdCamera) -> npt.NDArray[np.float64]:
    """Depth of the bench in the depth camera, 0 above the horizon and beyond 2 m."""
    v, u = np.mgrid[: depth.height, : depth.width]
    rays = np.stack([(u - depth.cx) / depth.fx, (v - depth.cy) / depth.fy, np.ones(u.shape)], -1)
    normal = camera.color_from_depth.rotation.T @ NORMAL
    offset_m = OFFSET_M + NORMAL @ camera.color_from_depth.translation
    toward = -(rays @ normal)
    result: npt.NDArray[np.float64] = np.where(
        toward > offset_m / 2, offset_m / np.maximum(toward, 1e-6), 0.0
    )
    return result
