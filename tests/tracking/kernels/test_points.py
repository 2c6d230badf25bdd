"""The closest measured point against brute force, and the surface points' correspondences."""

import dataclasses
from typing import Any

import numpy as np
import pytest
import twins
from scenes import CAMERA, bodies_at, both_cameras, focal_and_center, images_of, kernel_camera
from scenes import occlusion as occlusion_of

from snapfit.models.pose import Pose
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.kernels.depth import closest_measured, find_points
from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID, Points
from snapfit.tracking.parameters import DepthParameters

UNIT_M = 0.001
POINT_UNIT_M = 1e-5
HOLES = (0, 65535)
# For the second of two iterations; the first would find everything.
PARAMETERS = DepthParameters(
    considered_distances_m=(9.0, 0.05),
    standard_deviations_m=(9.0, 0.03),
    strides_m=(0.02, 0.005),
    beside=2.0,
    beside_slope=0.5,
)


def rough_depth(rng: np.random.Generator, depth_m: float, holes: float) -> np.ndarray:
    """Something at about a depth, and holes of both kinds."""
    shape = (CAMERA.height, CAMERA.width)
    depth = np.round(rng.normal(depth_m, 0.02, shape) / UNIT_M).astype(np.uint16)
    depth[rng.random(shape) < holes] = 0
    depth[rng.random(shape) < holes] = 65535
    return depth


def kernel_closest(
    depth: np.ndarray,
    stride_m: float,
    considered_m: float,
    point: np.ndarray,
    unit_m: float = UNIT_M,
) -> np.ndarray | None:
    found = np.full(3, np.nan, dtype=np.float32)
    hit = closest_measured(
        depth,
        kernel_camera(),
        np.float32(unit_m),
        np.float32(stride_m),
        np.float32(considered_m),
        *point.astype(np.float32),
        found,
    )
    return found if hit else None


def windows(
    depth: np.ndarray, stride_m: float, considered_m: float, point: np.ndarray
) -> tuple[np.ndarray, float]:
    """What brute force looks through, and how near the window is to being another."""
    stride_px = max(1, int(np.floor(stride_m * CAMERA.fx + 0.5)))
    n = max(1, int(np.floor(considered_m * CAMERA.fx / stride_px + 0.5)))
    reach_px = stride_px * n
    uv = CAMERA.project(point)
    window = twins.measured_window(depth, focal_and_center(), UNIT_M, stride_px, reach_px, point)
    return window, float(twins.margin_to_rounding(uv).min())


@pytest.mark.parametrize("holes", [0.0, 0.3, 0.49])
@pytest.mark.parametrize(
    ("stride_m", "considered_m"), [(0.005, 0.05), (0.008, 0.1), (0.02, 0.07), (0.001, 0.01)]
)
def test_the_closest_point_is_that_of_brute_force(
    stride_m: float, considered_m: float, holes: float
) -> None:
    rng = np.random.default_rng(int(1000 * holes))
    n_found, n_none = 0, 0
    images = [rough_depth(rng, depth_m, holes) for depth_m in np.arange(0.3, 1.0, 0.01)]
    for trial in range(300):
        image = int(rng.integers(len(images)))
        depth, z = images[image], 0.3 + 0.01 * image + considered_m * rng.uniform(-2, 2)
        uv = rng.uniform(0, [CAMERA.width - 1, CAMERA.height - 1])
        if trial % 3 == 0:
            # At the last pixel of the image, where half the window is missing.
            axis = rng.integers(2)
            uv[axis] = rng.choice([0.01, [CAMERA.width - 1.01, CAMERA.height - 1.01][axis]])
        point = np.array([*(uv - focal_and_center()[2:]) / focal_and_center()[:2] * z, z])
        window, margin = windows(depth, stride_m, considered_m, point)
        if margin < 1e-3:
            continue
        distances = np.linalg.norm(window - point, axis=1)
        closest = distances.min(initial=np.inf)
        if abs(closest - considered_m * z) < 1e-5:
            continue
        found = kernel_closest(depth, stride_m, considered_m, point)
        assert (found is not None) == (closest < considered_m * z)
        if found is None:
            n_none += 1
            continue
        n_found += 1
        assert np.linalg.norm(found - point) == pytest.approx(closest, abs=2e-6)
        assert np.abs(window - found).max(axis=1).min() < 1e-6
    assert n_found > 20
    assert n_none > 20


@pytest.mark.parametrize("hole", HOLES)
def test_holes_are_nothing(hole: int) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), hole, dtype=np.uint16)
    point = np.array([0.0, 0.0, 0.5])
    assert kernel_closest(depth, 0.005, 0.05, point) is None
    depth[101, 118] = 510
    found = kernel_closest(depth, 0.005, 0.05, point)
    assert found is not None
    assert found[2] == pytest.approx(0.51)


@pytest.mark.parametrize("hole", HOLES)
def test_holes_are_nothing_where_the_unit_is_fine_too(hole: int) -> None:
    """At 8 micrometres a count, 65535 would stand for half a metre."""
    unit_m = 0.5 / 65535
    depth = np.full((CAMERA.height, CAMERA.width), hole, dtype=np.uint16)
    assert kernel_closest(depth, 0.005, 0.05, np.array([0.0, 0.0, 0.5]), unit_m) is None
    depth[:] = 65534
    assert kernel_closest(depth, 0.005, 0.05, np.array([0.0, 0.0, 0.5]), unit_m) is not None


@pytest.mark.parametrize("uv", [(0, 0), (238, 0), (0, 198), (238, 198), (239, 199)])
def test_in_a_corner_of_the_image_the_window_is_cut(uv: tuple[int, int]) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 500, dtype=np.uint16)
    point = np.array([*(uv - focal_and_center()[2:]) / focal_and_center()[:2] * 0.5, 0.5])
    found = kernel_closest(depth, 0.005, 0.05, point)
    assert found is not None
    assert np.allclose(found, point, atol=1e-6)


def board_surface(n: int = 60) -> np.ndarray:
    """(N, 7) int16: points of a board in the plane z = 0, its normal to the camera."""
    rng = np.random.default_rng(3)
    surface = np.zeros((n, 7))
    surface[:, :2] = rng.uniform(-0.1, 0.1, (n, 2)) / POINT_UNIT_M
    surface[:, 5] = -32767
    return np.round(surface).astype(np.int16)


def find(
    surface: np.ndarray,
    pose: Pose,
    depth: np.ndarray,
    *,
    color_from_depth: Pose | None = None,
    parameters: DepthParameters | None = None,
    rows: tuple[int, int] | None = None,
    **hidden: Any,
) -> tuple[Points, np.ndarray]:
    """The points of one body at `depth_from_body`, and what became of them."""
    points = empty_points(1, len(surface))
    points.valid[:] = 7
    counts = np.zeros(4, dtype=np.int64)
    color_from_depth = color_from_depth or Pose.identity()
    bodies = bodies_at([color_from_depth @ pose])
    bodies.depth_poses[0] = pose.matrix
    find_points(
        0,
        *(rows or (0, len(surface))),
        1,
        images_of(depth=depth),
        both_cameras(color_from_depth=color_from_depth),
        bodies,
        surface,
        np.float32(POINT_UNIT_M),
        depth_settings(parameters or PARAMETERS, 2),
        occlusion_of(**hidden),
        points,
        counts,
        np.zeros(64, dtype=np.float32),
    )
    return points, counts


def flat(count: int) -> np.ndarray:
    return np.full((CAMERA.height, CAMERA.width), count)


@pytest.mark.parametrize("gap_m", [-0.02, 0.0, 0.008, 0.02])
def test_points_find_the_plane_behind_or_before_them(gap_m: float) -> None:
    surface, pose = board_surface(), Pose.from_translation(0.01, -0.02, 0.6)
    color_from_depth = Pose.exp([0.02, -0.1, 0.05, 0.03, 0.001, -0.002])
    points, counts = find(
        surface, pose, flat(600 + round(gap_m * 1000)), color_from_depth=color_from_depth
    )
    assert counts[:3].tolist() == [60, 0, 60]
    assert points.valid.all()
    assert np.allclose(points.point[0], surface[:, :3] * POINT_UNIT_M, atol=1e-7)
    assert np.allclose(points.normal[0], [0, 0, -1], atol=1e-6)
    assert np.allclose(points.weight[0], 1 / (0.03 * 0.6) ** 2, rtol=1e-4)
    measured = color_from_depth.inverse().transform(points.measured[0].astype(np.float64))
    wanted = pose.transform(points.point[0].astype(np.float64)) + np.array([0, 0, gap_m])
    assert np.allclose(measured[:, 2], wanted[:, 2], atol=1e-5)
    # In strides of 5 mm at 1 m (one pixel here), half a stride beside at most.
    assert np.abs(measured - wanted)[:, :2].max() < 0.0051 * 0.6


def test_nothing_beyond_the_considered_distance_is_found() -> None:
    pose = Pose.from_translation(0, 0, 0.6)
    for gap_mm, wanted in ((29, 60), (31, 0), (-29, 60), (-31, 0)):
        points, counts = find(board_surface(), pose, flat(600 + gap_mm))
        assert counts[:3].tolist() == [60, 0, wanted]
        assert points.valid.sum() == wanted


def test_what_lies_far_beside_the_normal_is_no_correspondence() -> None:
    """The border of a hole in the depth image may be near, but is not what the point meets."""
    depth = flat(600)
    depth[:, : int(CAMERA.cx)] = 0
    surface, pose = board_surface(), Pose.from_translation(0, 0, 0.6)
    points, counts = find(surface, pose, depth)
    x = surface[:, 0] * POINT_UNIT_M
    limit = 2 * 0.005 * 0.6
    assert points.valid[0, x > 0.004].all()
    assert not points.valid[0, x < -limit - 0.004].any()
    assert counts[VALID] == points.valid.sum()
    generous = dataclasses.replace(PARAMETERS, beside=100.0)
    found_beside, _ = find(surface, pose, depth, parameters=generous)
    assert found_beside.valid.sum() > points.valid.sum()


def test_hidden_points_are_counted_and_left_out() -> None:
    depth = flat(600)
    depth[:, : int(CAMERA.cx)] = 560
    surface, pose = board_surface(), Pose.from_translation(0, 0, 0.6)
    points, counts = find(surface, pose, depth, measured=True)
    x = surface[:, 0] * POINT_UNIT_M
    assert not points.valid[0, x < -0.012].any()
    assert points.valid[0, x > 0.012].all()
    assert (x < -0.012).sum() <= counts[OCCLUDED] <= (x < 0.012).sum()
    assert counts[CONSIDERED] == 60
    assert counts[VALID] == points.valid.sum() == 60 - counts[OCCLUDED]


def test_points_outside_the_image_or_behind_the_camera_are_not_considered() -> None:
    for translation in ((0, 0, -0.6), (0, 0, 0), (5, 0, 0.6), (0, -5, 0.6)):
        points, counts = find(board_surface(), Pose.from_translation(*translation), flat(600))
        assert not counts.any()
        assert not points.valid.any()


def test_only_its_own_part_of_the_points_is_looked_at() -> None:
    pose = Pose.from_translation(0, 0, 0.6)
    points, counts = find(board_surface(), pose, flat(605), rows=(20, 33))
    assert counts[:3].tolist() == [13, 0, 13]
    assert (points.valid[0, 20:33] == 1).all()
    assert (np.delete(points.valid[0], np.s_[20:33]) == 7).all()
