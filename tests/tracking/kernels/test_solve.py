"""The Newton step against NumPy's solver; the update of a pose against the exponential map."""

import numpy as np
import pytest
import twins
from scenes import random_pose, unit_vectors

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.solve import apply_variation, newton_step

ROTATION, TRANSLATION = 1000.0, 30000.0
BAD = [np.nan, np.inf, -np.inf]


def random_system(rng: np.random.Generator, rank: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Gradient and Hessian as the modalities give them: J^T J, metres and radians mixed."""
    jacobians = rng.normal(size=(rank, 6)) * [100, 100, 100, 1000, 1000, 1000]
    return rng.normal(size=6) * [1e3] * 6, jacobians.T @ jacobians


def lower(hessian: np.ndarray) -> np.ndarray:
    """The lower triangle, with NaN above it: that may not be read."""
    result = np.tril(hessian)
    result[np.triu_indices(6, 1)] = np.nan
    return result


@pytest.mark.parametrize("rank", [0, 1, 3, 6, 100])
def test_the_step_solves_the_regularised_system(rank: int) -> None:
    rng = np.random.default_rng(rank)
    tikhonov = np.diag([ROTATION] * 3 + [TRANSLATION] * 3)
    for _ in range(100):
        gradient, hessian = random_system(rng, rank)
        step = np.zeros(6)
        assert newton_step(gradient.copy(), lower(hessian), ROTATION, TRANSLATION, step)
        wanted = np.linalg.solve(hessian + tikhonov, -gradient)
        assert np.abs(step - wanted).max() < 1e-9 * np.abs(wanted).max()


def test_a_step_goes_downhill_and_none_is_needed_at_the_bottom() -> None:
    rng = np.random.default_rng(9)
    step = np.zeros(6)
    gradient, hessian = random_system(rng)
    assert newton_step(gradient, lower(hessian), ROTATION, TRANSLATION, step)
    assert gradient @ step < 0
    assert newton_step(np.zeros(6), lower(hessian), ROTATION, TRANSLATION, step)
    assert (step == 0).all()


@pytest.mark.parametrize("entry", range(6))
def test_a_system_that_is_not_positive_definite_has_no_step(entry: int) -> None:
    rng = np.random.default_rng(entry)
    gradient, hessian = random_system(rng)
    vectors = np.linalg.eigh(hessian)[1]
    values = np.linalg.eigvalsh(hessian)
    values[entry] = -10 * TRANSLATION
    indefinite = vectors @ np.diag(values) @ vectors.T
    assert not newton_step(gradient, lower(indefinite), ROTATION, TRANSLATION, np.zeros(6))


def test_a_singular_system_without_regularisation_has_no_step() -> None:
    assert not newton_step(np.ones(6), np.zeros((6, 6)), 0.0, 0.0, np.zeros(6))


@pytest.mark.parametrize("value", BAD)
def test_nothing_that_is_not_finite_passes_as_a_step(value: float) -> None:
    rng = np.random.default_rng(4)
    for row in range(6):
        gradient, hessian = random_system(rng)
        gradient[row] = value
        assert not newton_step(gradient, lower(hessian), ROTATION, TRANSLATION, np.zeros(6))
        for column in range(row + 1):
            gradient, hessian = random_system(rng)
            hessian[row, column] = value
            assert not newton_step(gradient, lower(hessian), ROTATION, TRANSLATION, np.zeros(6))


def test_a_step_that_overflows_is_none() -> None:
    hessian = np.diag(np.full(6, 1e-300))
    assert not newton_step(np.full(6, 1e30), hessian, 0.0, 0.0, np.zeros(6))


@pytest.mark.parametrize("angle_rad", [0.0, 1e-9, 9.9e-5, 1.01e-4, 1e-3, 0.1, 1.0, 3.0, 3.14159, 9])
def test_a_variation_turns_and_moves_in_the_body_frame(angle_rad: float) -> None:
    """Decoupled: pose @ [R(w) | v], not the exponential map of both together."""
    rng = np.random.default_rng(6)
    for axis in [*np.eye(3), *-np.eye(3), *unit_vectors(rng, (30, 3))]:
        pose, step = random_pose(rng), np.array([*(angle_rad * axis), *rng.normal(size=3)])
        moved = np.array(pose.matrix)
        apply_variation(moved, step)
        variation = np.eye(4)
        variation[:3, :3], variation[:3, 3] = twins.rotation(step[:3]), step[3:]
        assert np.allclose(moved, pose.matrix @ variation, rtol=0, atol=1e-12)


def test_pure_turns_and_pure_moves_are_those_of_the_exponential_map() -> None:
    rng = np.random.default_rng(7)
    for scale in (1e-6, 1e-2, 2.0):
        for part in (slice(0, 3), slice(3, 6)):
            pose, step = random_pose(rng), np.zeros(6)
            step[part] = scale * rng.normal(size=3)
            moved = np.array(pose.matrix)
            apply_variation(moved, step)
            assert np.allclose(moved, pose.perturbed(step).matrix, rtol=0, atol=1e-12)


def test_small_variations_differ_from_the_exponential_map_in_second_order_only() -> None:
    rng = np.random.default_rng(8)
    for scale in (1e-5, 1e-3, 1e-2):
        pose, step = random_pose(rng), scale * rng.normal(size=6)
        moved = np.array(pose.matrix)
        apply_variation(moved, step)
        difference = Pose(moved).distance_to(pose.perturbed(step))
        bound = np.linalg.norm(step[:3]) * np.linalg.norm(step[3:]) / 2
        assert difference <= 1.01 * bound
        assert Pose(moved).angle_to(pose.perturbed(step)) < 1e-9


def test_a_pose_stays_a_pose_through_an_hour_of_steps() -> None:
    rng = np.random.default_rng(10)
    pose = np.array(random_pose(rng).matrix)
    for step in rng.normal(scale=0.01, size=(100_000, 6)):
        apply_variation(pose, step)
    assert np.abs(pose[:3, :3] @ pose[:3, :3].T - np.eye(3)).max() < 1e-10
    assert pose[3].tolist() == [0, 0, 0, 1]
