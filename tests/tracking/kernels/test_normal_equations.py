"""Gradients and Hessians of both modalities against numerical differentiation of their energies.

The variation acts on the right, in the body frame, rotation first: pose @ exp(xi).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scenes import CAMERA, Array, kernel_camera, random_lines, random_points, random_pose

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.normal_equations import add_depth, add_region
from snapfit.tracking.kernels.types import Lines, Points
from snapfit.tracking.parameters import RegionParameters
from snapfit.tracking.region_modality import region_settings

N, N_USED = 60, 50
SEEDS = range(40)
SIGMAS_PX = (15.0, 2.5)
ITERATION = 1
PARAMETERS = RegionParameters(standard_deviations_px=SIGMAS_PX)
# Rotations by about 1e-4 rad and moves by 1e-5 m: below the curvature, above rounding.
STEPS = np.array([1e-4] * 3 + [1e-5] * 3)


def derivative(function: Callable[[Pose], Array], pose: Pose) -> Array:
    """Central differences (..., 6) over the variation of a pose."""
    columns = []
    for axis, step in enumerate(STEPS):
        variation = np.zeros(6)
        variation[axis] = step
        ahead, behind = function(pose.perturbed(variation)), function(pose.perturbed(-variation))
        columns.append((ahead - behind) / (2 * step))
    return np.stack(columns, axis=-1)


@dataclass(frozen=True)
class System:
    """Gradient (6,) and lower triangle of the Hessian (6, 6)."""

    gradient: Array
    hessian: Array

    def assert_is(self, gradient: Array, hessian: Array) -> None:
        """Equal but for single precision; measured in units that are of one size for all axes."""
        units = np.sqrt(np.diag(hessian))
        assert np.allclose(self.gradient / units, gradient / units, rtol=1e-3, atol=2e-3)
        relative = np.tril(hessian) / np.outer(units, units)
        assert np.allclose(self.hessian / np.outer(units, units), relative, atol=1e-3)
        assert (self.hessian[np.triu_indices(6, 1)] == 0).all()


def region_system(lines: Lines, pose: Pose, *, use_moments: bool, n: int = N_USED) -> System:
    gradient, hessian = np.zeros(6), np.zeros((6, 6))
    add_region(
        1,
        n,
        pose.matrix.astype(np.float32),
        kernel_camera(),
        region_settings(PARAMETERS, 2),
        ITERATION,
        use_moments,
        lines,
        gradient,
        hessian,
        np.zeros(6, dtype=np.float32),
    )
    return System(gradient, hessian)


def depth_system(points: Points, pose: Pose, n: int = N_USED) -> System:
    gradient, hessian = np.zeros(6), np.zeros((6, 6))
    add_depth(
        1,
        n,
        pose.matrix.astype(np.float32),
        points,
        gradient,
        hessian,
        np.zeros(6, dtype=np.float32),
    )
    return System(gradient, hessian)


def used(valid: Array) -> Array:
    return np.flatnonzero(valid[1, :N_USED])


def line_offsets(lines: Lines, pose: Pose) -> Array:
    """(N,) where the model's contour lies on the lines, segments from their centres."""
    place = lines.place[1].astype(np.float64)
    moved = CAMERA.project(pose.transform(lines.point[1].astype(np.float64))) - place[:, :2]
    return ((moved * place[:, 2:4]).sum(axis=1) - place[:, 4]) * place[:, 5]


def line_weights(lines: Lines, pose: Pose) -> Array:
    """(N,) smallest variance / (sigma^2 of the contour in segments^2), times Cauchy's weight."""
    per_px, sigma_px = lines.place[1, :, 5].astype(np.float64), SIGMAS_PX[ITERATION]
    apart_px = (lines.moments[1, :, 0] - line_offsets(lines, pose)) / per_px
    cauchy = 1 / (1 + (apart_px / (PARAMETERS.outlying * sigma_px)) ** 2)
    return cauchy * PARAMETERS.min_variance / (per_px * sigma_px) ** 2


def point_errors(points: Points, pose: Pose) -> Array:
    """(N,) signed distance of the model's points from the measured ones, along the normals, m."""
    place, normal, measured = (
        array[1].astype(np.float64) for array in (points.point, points.normal, points.measured)
    )
    return ((normal @ pose.rotation.T) * (pose.transform(place) - measured)).sum(axis=1)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_regions_global_gradient_is_that_of_the_gaussian_energy(seed: int) -> None:
    """Sum of weight (mean - offset)^2 / (2 variance), Cauchy's weights held."""
    rng = np.random.default_rng(seed)
    pose = random_pose(rng)
    lines = random_lines(rng, N, pose)
    on, weights = used(lines.valid), line_weights(lines, pose)
    mean, variance = lines.moments[1].astype(np.float64).T

    def energy(at: Pose) -> Array:
        return (weights * (mean - line_offsets(lines, at)) ** 2 / (2 * variance))[on].sum()

    jacobian = derivative(lambda at: line_offsets(lines, at), pose)[on]
    hessian = jacobian.T @ (jacobian * (weights / variance)[on, None])
    region_system(lines, pose, use_moments=True).assert_is(derivative(energy, pose), hessian)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_regions_local_gradient_is_that_of_the_posterior(seed: int) -> None:
    """Sum of - weight rate / variance log p(offset), log p linear between the bins."""
    rng = np.random.default_rng(seed)
    pose = random_pose(rng)
    lines = random_lines(rng, N, pose)
    offsets = line_offsets(lines, pose) + 5.5
    # At a bin's middle the slope jumps; differences across it would mean nothing.
    lines.valid[1, np.abs(offsets - np.round(offsets)) < 0.03] = 0
    lines.valid[1] &= (offsets > 0) & (offsets < 11)
    on, weights = used(lines.valid), line_weights(lines, pose)
    variance = lines.moments[1, :, 1].astype(np.float64)
    logarithms = np.log(lines.posterior[1].astype(np.float64))

    def energy(at: Pose) -> Array:
        places = line_offsets(lines, at) + 5.5
        value = [np.interp(x, np.arange(12), p) for x, p in zip(places, logarithms, strict=True)]
        return -(weights * PARAMETERS.learning_rate / variance * value)[on].sum()

    jacobian = derivative(lambda at: line_offsets(lines, at), pose)[on]
    hessian = jacobian.T @ (jacobian * (weights / variance)[on, None])
    assert len(on) > 12
    region_system(lines, pose, use_moments=False).assert_is(derivative(energy, pose), hessian)


def test_the_local_gradient_leaves_out_lines_beyond_their_bins() -> None:
    rng = np.random.default_rng(7)
    pose = random_pose(rng)
    lines = random_lines(rng, N, pose)
    lines.place[1, :, 4] += np.where(np.arange(N) % 2, 6.6, -6.6) / lines.place[1, :, 5]
    outside = np.abs(line_offsets(lines, pose)) > 5.51
    assert outside.sum() > 30
    lines.valid[1] &= outside
    beyond = region_system(lines, pose, use_moments=False)
    assert not beyond.gradient.any()
    assert not beyond.hessian.any()
    assert region_system(lines, pose, use_moments=True).gradient.any()


def test_a_posterior_of_zeros_gives_a_finite_slope() -> None:
    rng = np.random.default_rng(8)
    pose = random_pose(rng)
    lines = random_lines(rng, N, pose)
    lines.posterior[1] = 0
    lines.posterior[1, :, 6] = 1
    assert np.isfinite(region_system(lines, pose, use_moments=False).gradient).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_depths_gradient_is_that_of_the_point_to_plane_energy(seed: int) -> None:
    """Sum of weight error^2 / 2; the plane turns with the body, what is measured stays."""
    rng = np.random.default_rng(seed)
    pose = random_pose(rng)
    points = random_points(rng, N, pose)
    on, weights = used(points.valid), points.weight[1].astype(np.float64)

    def energy(at: Pose) -> Array:
        return (weights * point_errors(points, at) ** 2 / 2)[on].sum()

    jacobian = derivative(lambda at: point_errors(points, at), pose)[on]
    hessian = jacobian.T @ (jacobian * weights[on, None])
    depth_system(points, pose).assert_is(derivative(energy, pose), hessian)


def test_both_modalities_add_to_what_is_there() -> None:
    rng = np.random.default_rng(9)
    pose = random_pose(rng)
    lines, points = random_lines(rng, N, pose), random_points(rng, N, pose)
    gradient, hessian, room = np.full(6, 5.0), np.full((6, 6), 7.0), np.zeros(6, dtype=np.float32)
    matrix = pose.matrix.astype(np.float32)
    settings = region_settings(PARAMETERS, 2)
    add_region(
        1, N_USED, matrix, kernel_camera(), settings, 1, True, lines, gradient, hessian, room
    )
    add_depth(1, N_USED, matrix, points, gradient, hessian, room)
    region = region_system(lines, pose, use_moments=True)
    depth = depth_system(points, pose)
    assert np.allclose(gradient - 5, region.gradient + depth.gradient)
    assert np.allclose(np.tril(hessian - 7), region.hessian + depth.hessian)
    assert (hessian[np.triu_indices(6, 1)] == 7).all()


def test_only_valid_lines_and_points_of_the_body_itself_count() -> None:
    rng = np.random.default_rng(10)
    pose = random_pose(rng)
    lines, points = random_lines(rng, N, pose), random_points(rng, N, pose)
    before = region_system(lines, pose, use_moments=True), depth_system(points, pose)
    for arrays, valid in ((lines[:-1], lines.valid), (points[:-1], points.valid)):
        for array in arrays:
            array[1, N_USED:], array[0] = np.nan, np.nan
            array[1, valid[1] == 0] = np.nan
    after = region_system(lines, pose, use_moments=True), depth_system(points, pose)
    for one, other in zip(before, after, strict=True):
        assert np.array_equal(one.gradient, other.gradient)
        assert np.array_equal(one.hessian, other.hessian)


def test_lines_of_points_behind_the_camera_do_not_count() -> None:
    rng = np.random.default_rng(11)
    pose = random_pose(rng)
    behind = Pose.from_translation(0, 0, -2) @ pose
    system = region_system(random_lines(rng, N, pose), behind, use_moments=True)
    assert not system.gradient.any()
    assert not system.hessian.any()
