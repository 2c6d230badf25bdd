"""The covariance of linked bodies against one dense system, and the systematic errors on top."""

import numpy as np
import pytest
from scenes import Array, bodies_at
from trees import PARENTS, tree

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.covariance import CovarianceSettings, covariances
from snapfit.tracking.kernels.types import Bodies
from snapfit.tracking.kinematics import KinematicStructures

CENTERS = np.array(
    [[0.02, -0.03, 0.05], [0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3], [1, 1, 1]]
)
SCATTER = CovarianceSettings(0.5, 4.0, 100.0, 0.0, 0.0, 0.0)
SYSTEMATIC = CovarianceSettings(1.0, 4.0, 100.0, 0.002, 0.0003, 0.005)


def stated(structures: KinematicStructures, bodies: Bodies, settings: CovarianceSettings) -> Array:
    n = len(bodies.poses)
    found = np.full((n, 6, 6), np.nan)
    covariances(structures.arrays, bodies, CENTERS[:n], settings, found)
    return found


def full(lower: Array) -> Array:
    return lower + np.tril(lower, -1).T


def dense(structures: KinematicStructures, bodies: Bodies, settings: CovarianceSettings) -> Array:
    """(B, 6, 6) from the inverse Hessian over the root's variation and all coordinates."""
    columns = [(b, d) for b in range(len(PARENTS)) for d in range(structures.arrays.n_dof[b])]
    size = 6 + len(columns)
    jacobians = np.zeros((len(PARENTS), 6, size))
    jacobians[0, :, :6] = np.eye(6)
    prior = np.zeros(size)
    prior[:6] = [settings.prior_rotation] * 3 + [settings.prior_translation] * 3
    for body, parent in enumerate(PARENTS):
        if parent >= 0:
            relative = Pose(bodies.poses[body]).inverse() @ Pose(bodies.poses[parent])
            jacobians[body] = relative.adjoint() @ jacobians[parent]
        for i, (owner, d) in enumerate(columns):
            if owner == body:
                twist = structures.arrays.twists[body, d]
                jacobians[body, :, 6 + i] += twist
                turns = np.any(twist[:3])
                prior[6 + i] = settings.prior_rotation if turns else settings.prior_translation
    hessian = np.diag(prior)
    for jacobian, lower in zip(jacobians, bodies.hessians, strict=True):
        hessian += settings.information * jacobian.T @ full(lower) @ jacobian
    return jacobians @ np.linalg.inv(hessian) @ np.swapaxes(jacobians, 1, 2)


def test_linked_bodies_have_the_marginals_of_one_dense_system() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        structures, bodies = tree(rng)
        bodies.hessians[4] = 0.0
        wanted = dense(structures, bodies, SCATTER)
        assert np.allclose(stated(structures, bodies, SCATTER), wanted, rtol=1e-8, atol=1e-12)


def free_body(rng: np.random.Generator) -> tuple[KinematicStructures, Bodies]:
    pose = Pose.from_rotation_translation(Pose.exp([0.3, -0.8, 0.5, 0, 0, 0]).rotation, (0, 0, 0.7))
    bodies = bodies_at([pose])
    jacobians = rng.normal(size=(20, 6)) * [50, 50, 50, 1000, 1000, 1000]
    bodies.hessians[0] = np.tril(jacobians.T @ jacobians)
    return KinematicStructures(1), bodies


def test_a_body_that_is_linked_is_known_better_than_alone() -> None:
    structures, bodies = tree(np.random.default_rng(1))
    together = stated(structures, bodies, SCATTER)
    alone = stated(KinematicStructures(len(PARENTS)), bodies, SCATTER)
    assert (np.linalg.eigvalsh(alone - together).min(axis=1) > -1e-10).all()
    bodies.hessians[1] = 0.0
    hidden = stated(structures, bodies, SCATTER)[1]
    assert np.trace(hidden[3:, 3:]) < 0.05 * 3 / SCATTER.prior_translation


def test_nothing_seen_leaves_what_was_known_before() -> None:
    structures, bodies = free_body(np.random.default_rng(2))
    bodies.active[:] = 0
    prior = np.diag([1 / 4] * 3 + [1 / 100] * 3)
    assert np.allclose(stated(structures, bodies, SCATTER)[0], prior)
    bodies.active[:] = 1
    bodies.hessians[0] = np.nan
    assert np.isnan(stated(structures, bodies, SCATTER)[0]).all()


def test_systematic_errors_lie_along_the_line_of_sight_and_about_the_middle() -> None:
    structures, bodies = free_body(np.random.default_rng(3))
    scatter = np.linalg.inv(full(bodies.hessians[0]) + np.diag([4.0] * 3 + [100.0] * 3))
    added = stated(structures, bodies, SYSTEMATIC)[0] - scatter
    pose = Pose(bodies.poses[0])
    middle = Pose.from_translation(*-CENTERS[0]).adjoint() @ added
    middle = middle @ Pose.from_translation(*-CENTERS[0]).adjoint().T
    assert np.allclose(middle[:3, :3], 0.005**2 * np.eye(3))
    assert np.allclose(middle[:3, 3:], 0, atol=1e-12)
    seen = pose.rotation @ CENTERS[0] + pose.translation
    in_camera = pose.rotation @ middle[3:, 3:] @ pose.rotation.T
    along = 0.002**2 * np.outer(seen, seen)
    assert np.allclose(in_camera, 0.0003**2 * np.eye(3) + along, atol=1e-15)


def test_more_of_the_same_evidence_never_beats_the_systematic_error() -> None:
    structures, bodies = free_body(np.random.default_rng(4))
    bodies.hessians[0] *= 1e9
    found = stated(structures, bodies, SYSTEMATIC)[0]
    assert np.sqrt(np.linalg.eigvalsh(found[:3, :3])) == pytest.approx(0.005, rel=1e-3)
