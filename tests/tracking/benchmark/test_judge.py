import math

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.symmetry import (
    NO_SYMMETRY,
    Symmetry,
    SymmetryAxis,
    distance_modulo_symmetry,
)
from snapfit.tracking.benchmark.consistency import normalised_error
from snapfit.tracking.benchmark.judge import MISSED, PartJudge

CAMERA = PinholeCamera(640, 480, 600, 600, 320, 240)
AXIS = SymmetryAxis(np.array([0.3, -1.0, 0.5]), np.array([0.02, 0.01, -0.03]))
HALF_TURN = Pose.exp([0, 0, math.pi, 0, 0, 0])
SWAP = SymmetryAxis(np.array([1.0, 0.3, 0.0]), AXIS.point_m).turn(math.pi)
"""Exchanges the ends of the axis."""
ESTIMATE = Pose.exp([0.4, -0.2, 0.7, 0.1, 0.0, 0.6])


def part(symmetry: Symmetry) -> Part:
    box = trimesh.creation.box((0.04, 0.05, 0.06))
    mesh = Mesh(box.vertices.astype(np.float32), box.faces.astype(np.int32))
    return Part("box", mesh, symmetry=symmetry)


def random_covariance(rng: np.random.Generator) -> np.ndarray:
    scale = np.diag([0.02, 0.01, 0.03, 0.001, 0.003, 0.002])
    mix = np.eye(6) + 0.3 * rng.normal(size=(6, 6))
    return scale @ mix @ mix.T @ scale


@pytest.mark.parametrize("symmetry", [NO_SYMMETRY, Symmetry((HALF_TURN,)), Symmetry((), AXIS)])
def test_errors_are_those_modulo_symmetry(symmetry: Symmetry) -> None:
    rng = np.random.default_rng(4)
    judge = PartJudge(part(symmetry), CAMERA)
    for _ in range(5):
        truth = ESTIMATE.perturbed(rng.normal(size=6) * [2, 2, 2, 0.01, 0.01, 0.01])
        errors, nees = judge.judge(ESTIMATE, truth)
        expected = distance_modulo_symmetry(truth, ESTIMATE, symmetry)
        assert (errors.translation_m, errors.rotation_rad) == pytest.approx(expected)
        assert np.isnan(nees).all()


def test_without_an_estimate_there_are_no_errors_but_failures() -> None:
    errors, nees = PartJudge(part(NO_SYMMETRY), CAMERA).judge(None, ESTIMATE, np.eye(6))
    assert errors is MISSED
    assert np.isnan(nees).all()


def test_the_normalised_error_is_that_of_the_formula() -> None:
    rng = np.random.default_rng(1)
    covariance = random_covariance(rng)
    error = rng.multivariate_normal(np.zeros(6), covariance)
    truth = ESTIMATE.perturbed(error)
    found = normalised_error(ESTIMATE, ESTIMATE, truth, NO_SYMMETRY, covariance)
    whole = error @ np.linalg.inv(covariance) @ error / 6
    rotation = error[:3] @ np.linalg.inv(covariance[:3, :3]) @ error[:3] / 3
    translation = error[3:] @ np.linalg.inv(covariance[3:, 3:]) @ error[3:] / 3
    assert found == pytest.approx([whole, rotation, translation], rel=1e-6)


@pytest.mark.parametrize(
    "symmetry",
    [NO_SYMMETRY, Symmetry((HALF_TURN,)), Symmetry((), AXIS), Symmetry((SWAP,), AXIS)],
)
def test_an_honest_covariance_has_a_normalised_error_of_one(symmetry: Symmetry) -> None:
    """Errors drawn from the covariance, and then a motion that nobody can see."""
    rng = np.random.default_rng(2)
    covariance = 0.1**2 * random_covariance(rng)
    judge = PartJudge(part(symmetry), CAMERA)
    found = []
    for error in rng.multivariate_normal(np.zeros(6), covariance, 1500):
        truth = ESTIMATE.perturbed(error)
        for motion in symmetry.motions:
            truth = truth @ motion if rng.random() < 0.5 else truth
        if symmetry.axis is not None:
            truth = truth @ symmetry.axis.turn(rng.uniform(0, 6))
        found.append(judge.judge(ESTIMATE, truth, covariance)[1])
    assert np.mean(found, axis=0) == pytest.approx([1, 1, 1], abs=0.1)


def test_the_variance_of_a_turn_about_the_axis_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    covariance = random_covariance(rng)
    turn = np.concatenate([AXIS.direction, np.cross(AXIS.point_m, AXIS.direction)])
    truth = ESTIMATE.perturbed(rng.normal(size=6) * 0.001)
    judge = PartJudge(part(Symmetry((), AXIS)), CAMERA)
    found = [
        judge.judge(ESTIMATE, truth, covariance + variance * np.outer(turn, turn))[1]
        for variance in (0.0, 1e-4, 1.0)
    ]
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)
    np.testing.assert_allclose(found[2], found[0], rtol=1e-6)


def test_a_covariance_that_knows_something_exactly_is_no_covariance() -> None:
    singular = np.diag([1.0, 1, 1, 0, 0, 0])
    found = normalised_error(ESTIMATE, ESTIMATE, ESTIMATE, NO_SYMMETRY, singular)
    assert np.isnan(found[[0, 2]]).all()
    assert found[1] == pytest.approx(0, abs=1e-20)
