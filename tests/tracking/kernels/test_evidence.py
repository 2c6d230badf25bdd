"""Which lines and points agree with a pose, and how likely they make it."""

import numpy as np
import pytest
from scenes import (
    CAMERA,
    Array,
    bodies_at,
    both_cameras,
    counted_models,
    kernel_camera,
    random_lines,
    random_points,
    random_pose,
)

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.evidence import weigh_bodies, weigh_lines, weigh_points
from snapfit.tracking.kernels.types import Lines, Points

TOLERANCE_PX, TOLERANCE_M = 3.0, 0.006


def line_offsets(lines: Lines, pose: Pose, body: int = 1) -> Array:
    """Where the model's contour lies on each line, segments from the line's centre."""
    place = lines.place[body].astype(np.float64)
    moved = CAMERA.project(pose.transform(lines.point[body].astype(np.float64))) - place[:, :2]
    return ((moved * place[:, 2:4]).sum(axis=1) - place[:, 4]) * place[:, 5]


def line_twin(lines: Lines, pose: Pose) -> tuple[Array, Array]:
    """(n,) whether a line agrees; (n,) its log likelihood against an even posterior."""
    offsets = line_offsets(lines, pose)
    mean, variance = lines.moments[1].astype(np.float64).T
    agrees = (np.abs(mean - offsets) < TOLERANCE_PX * lines.place[1, :, 5]) & (variance < 6)
    bins = np.round(offsets + 5.5).astype(int)
    on = (bins >= 0) & (bins < 12)
    share = np.where(on, lines.posterior[1, np.arange(len(bins)), np.clip(bins, 0, 11)], 0)
    return agrees, np.maximum(np.log(12 * np.maximum(share, 1e-6)), -2.5)


def point_errors(points: Points, pose: Pose) -> Array:
    place, normal, measured = (
        array[1].astype(np.float64) for array in (points.point, points.normal, points.measured)
    )
    return ((normal @ pose.rotation.T) * (pose.transform(place) - measured)).sum(axis=1)


def test_lines_are_weighed_like_their_twin() -> None:
    rng = np.random.default_rng(1)
    total, agreeing_total = 0, 0
    for _ in range(40):
        pose = random_pose(rng)
        lines = random_lines(rng, 80, pose)
        borders = line_offsets(lines, pose)
        near_a_border = np.abs(borders - np.round(borders)) < 2e-3
        near_a_border |= (
            np.abs(np.abs(lines.moments[1, :, 0] - borders) - TOLERANCE_PX * lines.place[1, :, 5])
            < 2e-3
        )
        lines.valid[1, near_a_border] = 0
        on = lines.valid[1, :70] == 1
        agrees, likelihood = line_twin(lines, pose)
        found = weigh_lines(
            1, 70, kernel_camera(), pose.matrix.astype(np.float32), lines, np.float32(TOLERANCE_PX)
        )
        assert found[0] == agrees[:70][on].sum()
        assert found[1] == pytest.approx(likelihood[:70][on].sum(), rel=1e-4, abs=1e-3)
        total, agreeing_total = total + on.sum(), agreeing_total + found[0]
    assert 0.1 * total < agreeing_total < 0.9 * total


def test_points_are_weighed_like_their_twin() -> None:
    rng = np.random.default_rng(2)
    total, agreeing_total = 0, 0
    for _ in range(40):
        pose = random_pose(rng)
        points = random_points(rng, 80, pose)
        errors = point_errors(points, pose)
        points.valid[1, np.abs(np.abs(errors) - TOLERANCE_M) < 1e-6] = 0
        on = points.valid[1, :70] == 1
        share = errors[:70][on] / TOLERANCE_M
        found = weigh_points(1, 70, pose.matrix.astype(np.float32), points, np.float32(TOLERANCE_M))
        assert found[0] == (np.abs(share) < 1).sum()
        assert found[1] == pytest.approx(np.maximum(1 - share**2, -1).sum(), abs=2e-2)
        depths = pose.transform(points.point[1].astype(np.float64))[:70][on, 2]
        rms = np.sqrt(np.mean((errors[:70][on] / depths) ** 2))
        assert found[2] == pytest.approx(rms, rel=1e-3)
        total, agreeing_total = total + on.sum(), agreeing_total + found[0]
    assert 0.1 * total < agreeing_total < 0.9 * total


def weigh(
    lines: Lines, points: Points, poses: list[Pose], active: list[int]
) -> tuple[Array, Array]:
    bodies = bodies_at(poses)
    bodies.active[:] = active
    bodies.color_poses[:] = np.nan
    support, likelihoods = np.full((2, 2), -1), np.full(2, np.nan)
    weigh_bodies(
        both_cameras(),
        counted_models([60, 60], [50, 50]),
        bodies,
        lines,
        points,
        TOLERANCE_PX,
        TOLERANCE_M,
        support,
        likelihoods,
        np.zeros(2),
    )
    return support, likelihoods


def test_bodies_are_weighed_one_by_one_and_inactive_ones_have_no_support() -> None:
    rng = np.random.default_rng(3)
    pose = random_pose(rng)
    lines, points = random_lines(rng, 80, pose), random_points(rng, 80, pose)
    support, likelihoods = weigh(lines, points, [Pose.identity(), pose], [0, 1])
    matrix = pose.matrix.astype(np.float32)
    by_lines = weigh_lines(1, 60, kernel_camera(), matrix, lines, np.float32(TOLERANCE_PX))
    by_points = weigh_points(1, 50, matrix, points, np.float32(TOLERANCE_M))
    assert support.tolist() == [[0, 0], [by_lines[0], by_points[0]]]
    assert likelihoods[0] == -np.inf
    assert likelihoods[1] == pytest.approx(by_lines[1] + by_points[1])


def test_without_correspondences_nothing_speaks_for_a_pose() -> None:
    rng = np.random.default_rng(4)
    pose = random_pose(rng)
    lines, points = random_lines(rng, 80, pose), random_points(rng, 80, pose)
    lines.valid[:], points.valid[:] = 0, 0
    support, likelihoods = weigh(lines, points, [pose, pose], [1, 1])
    assert not support.any()
    assert (likelihoods == 0).all()


def test_the_likelihood_is_highest_where_the_evidence_is() -> None:
    """Lines and points that were made at a pose make that pose likelier than those about it."""
    rng = np.random.default_rng(5)
    pose = random_pose(rng)
    lines, points = random_lines(rng, 80, pose), random_points(rng, 80, pose)
    lines.place[1, :, :2] = CAMERA.project(pose.transform(lines.point[1]))
    lines.place[1, :, 4] = 0
    bins = np.arange(12) - 5.5
    lines.posterior[1] = np.exp(-(bins**2) / 2) / np.exp(-(bins**2) / 2).sum()
    lines.moments[1] = 0, 1
    lines.place[1, :, 5] = 0.5
    points.measured[1] = pose.transform(points.point[1])
    _, (_, best) = weigh(lines, points, [pose, pose], [1, 1])
    for axis in range(6):
        for sign in (-1, 1):
            variation = np.zeros(6)
            variation[axis] = sign * (0.15 if axis < 3 else 0.01)
            _, (_, other) = weigh(lines, points, [pose, pose.perturbed(variation)], [1, 1])
            assert other < best - 1
