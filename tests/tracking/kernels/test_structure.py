"""The Newton step of linked bodies against one dense system; limits; the exponential map."""

import numpy as np
import pytest
from scenes import Array, bodies_at, random_pose
from trees import PARENTS, joint_of, tree

from snapfit.models.pose import Pose
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.kernels.solve import exponential
from snapfit.tracking.kernels.structure import relative_adjoint, step_structure
from snapfit.tracking.kernels.types import Bodies
from snapfit.tracking.kinematics import KinematicStructures

TIKHONOV = np.array([1000.0, 30000.0])


def dense_step(structures: KinematicStructures, bodies: Bodies, free: Array) -> tuple:
    """Jacobians (B, 6, 6 + D) of all bodies over root and coordinates, and the regularised step."""
    columns = [(b, d) for b in range(len(PARENTS)) for d in range(structures.arrays.n_dof[b])]
    size = 6 + len(columns)
    jacobians = np.zeros((len(PARENTS), 6, size))
    jacobians[0, :, :6] = np.eye(6)
    penalty = np.zeros(size)
    penalty[:6] = [TIKHONOV[0]] * 3 + [TIKHONOV[1]] * 3
    for body, parent in enumerate(PARENTS):
        if parent < 0:
            continue
        relative = Pose(bodies.poses[body]).inverse() @ Pose(bodies.poses[parent])
        jacobians[body] = relative.adjoint() @ jacobians[parent]
        for i, (owner, d) in enumerate(columns):
            if owner == body:
                twist = structures.arrays.twists[body, d]
                jacobians[body, :, 6 + i] += twist
                penalty[6 + i] = TIKHONOV[0] if np.any(twist[:3]) else TIKHONOV[1]
    hessian, gradient = np.diag(penalty), np.zeros(size)
    for body in range(len(PARENTS)):
        lower = bodies.hessians[body]
        full = lower + np.tril(lower, -1).T
        hessian += jacobians[body].T @ full @ jacobians[body]
        gradient += jacobians[body].T @ bodies.gradients[body]
    step = np.zeros(size)
    step[free] = np.linalg.solve(hessian[np.ix_(free, free)], -gradient[free])
    return columns, step


def varied(pose: Array, step: Array) -> Array:
    """A pose turned and then moved in its own frame, as `apply_variation` does."""
    turn = Pose.exp([*step[:3], 0, 0, 0])
    return (Pose(pose) @ Pose.from_translation(*step[3:6]) @ turn).matrix


def test_the_step_is_that_of_one_dense_system() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        structures, bodies = tree(rng)
        before, q = bodies.poses.copy(), structures.arrays.q.copy()
        columns, step = dense_step(structures, bodies, np.arange(6 + 5))
        step_structure(0, structures.arrays, bodies, TIKHONOV)
        for (body, d), wanted in zip(columns, step[6:], strict=True):
            assert structures.arrays.q[body, d] - q[body, d] == pytest.approx(wanted, rel=1e-8)
        assert np.allclose(bodies.poses[0], varied(before[0], step), atol=1e-12)
        for body in range(1, len(PARENTS)):
            parent = Pose(bodies.poses[PARENTS[body]])
            linked = parent @ structures.parent_from_child(body)
            assert np.allclose(bodies.poses[body], linked.matrix, atol=1e-12)


def test_a_coordinate_stops_at_its_limit_and_the_others_make_the_best_of_it() -> None:
    rng = np.random.default_rng(1)
    n_stopped = 0
    for _ in range(40):
        structures, bodies = tree(rng, travel_m=(-0.0001, 0.0001))
        start = structures.arrays.q[3, 0]
        q = structures.arrays.q.copy()
        step_structure(0, structures.arrays, bodies, TIKHONOV)
        assert -0.0001 <= structures.arrays.q[3, 0] <= 0.0001
        assert start == q[3, 0]
        n_stopped += abs(structures.arrays.q[3, 0]) == 0.0001
    assert n_stopped > 20


def test_free_bodies_step_by_themselves_and_a_failed_step_moves_nothing() -> None:
    rng = np.random.default_rng(2)
    structures = KinematicStructures(2)
    bodies = bodies_at([random_pose(rng), random_pose(rng)])
    for body in range(2):
        bodies.hessians[body] = np.eye(6) * 1e5
        bodies.gradients[body] = rng.normal(size=6) * 1e3
    bodies.gradients[1, 2] = np.nan
    before = bodies.poses.copy()
    for structure in range(2):
        step_structure(structure, structures.arrays, bodies, TIKHONOV)
    assert bodies.solved.tolist() == [1, 0]
    assert np.array_equal(bodies.poses[1], before[1])
    wanted = -bodies.gradients[0] / (1e5 + np.repeat(TIKHONOV, 3))
    assert np.allclose(bodies.poses[0], varied(before[0], wanted), atol=1e-12)


def test_relative_adjoints_and_exponentials_are_those_of_the_poses() -> None:
    rng = np.random.default_rng(3)
    for scale in (1e-6, 1e-3, 1.0):
        parent, child = random_pose(rng), random_pose(rng)
        adjoint, moved = np.empty((6, 6)), np.empty((4, 4))
        relative_adjoint(parent.matrix, child.matrix, adjoint)
        assert np.allclose(adjoint, (child.inverse() @ parent).adjoint(), atol=1e-12)
        twist = scale * rng.normal(size=6)
        exponential(twist, moved)
        assert np.allclose(moved, Pose.exp(twist).matrix, atol=1e-13)


def test_links_make_trees_and_leave_them() -> None:
    rng = np.random.default_rng(4)
    structures, _ = tree(rng)
    assert structures.members(5).tolist() == structures.members(0).tolist()
    assert structures.root(5) == 0
    structures.unlink(3)
    assert structures.members(3).tolist() == [3, 5]
    assert sorted(structures.members(0).tolist()) == [0, 1, 2, 4]
    with pytest.raises(TrackingError, match="no root"):
        structures.link(1, 2, joint_of(rng, "fixed"), np.zeros(0))
    with pytest.raises(TrackingError, match="no root"):
        structures.link(3, 5, joint_of(rng, "fixed"), np.zeros(0))
