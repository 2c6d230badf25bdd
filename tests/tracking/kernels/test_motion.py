"""The motion prior: what moved goes on, what rested rests, joints stay within their limits."""

import numpy as np
import pytest
from scenes import bodies_at, random_pose

from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Joint, JointType, Link
from snapfit.models.pose import Pose
from snapfit.tracking.kernels.motion import predict, relative_motion
from snapfit.tracking.kinematics import KinematicStructures

LEAST_TURN, LEAST_WAY = 0.01, 0.001


def predicted(before, now, damping=1.0, structures=None, q_before=None, moving=None):
    bodies = bodies_at(now)
    structures = structures or KinematicStructures(len(now))
    predict(
        bodies,
        structures.arrays,
        np.array([pose.matrix for pose in before]),
        np.zeros((len(now), 2)) if q_before is None else q_before,
        np.ones(len(now), dtype=np.uint8) if moving is None else moving,
        damping,
        LEAST_TURN,
        LEAST_WAY,
    )
    return [Pose(matrix) for matrix in bodies.poses]


def test_a_steady_turn_goes_on() -> None:
    rng = np.random.default_rng(0)
    for angle in (0.05, 0.5, 2.5):
        start = random_pose(rng)
        axis = rng.normal(size=3)
        turn = Pose.exp([*(angle * axis / np.linalg.norm(axis)), 0, 0, 0])
        (after,) = predicted([start], [start @ turn])
        assert after.angle_to(start @ turn @ turn) < 1e-6
        assert after.distance_to(start) < 1e-9


def test_a_steady_way_goes_on_and_is_damped() -> None:
    start = random_pose(np.random.default_rng(1))
    way = Pose.from_translation(0.01, -0.02, 0.005)
    (after,) = predicted([start], [way @ start], damping=0.5)
    wanted = start.translation + 1.5 * np.array([0.01, -0.02, 0.005])
    assert np.allclose(after.translation, wanted, atol=1e-12)


def test_what_rests_or_cannot_be_believed_stays() -> None:
    rng = np.random.default_rng(2)
    start = random_pose(rng)
    tremor = start @ Pose.exp([0.002, 0.001, 0, 0.0002, 0, 0])
    moved = start @ Pose.exp([0.2, 0, 0, 0.02, 0, 0])
    poses = predicted([start, start], [tremor, moved], moving=np.array([1, 0], dtype=np.uint8))
    assert np.array_equal(poses[0].matrix, tremor.matrix)
    assert np.array_equal(poses[1].matrix, moved.matrix)


def test_a_joint_goes_on_to_its_limit_and_the_child_follows() -> None:
    joint = JointMotion.of(
        Link(
            parent="a",
            child="b",
            parent_from_child=Pose.from_translation(0.1, 0, 0),
            joint=Joint(type=JointType.PRISMATIC, axis=(0, 0, 1), travel_m=(-0.05, 0.012)),
        )
    )
    structures = KinematicStructures(2)
    structures.link(1, 0, joint, np.array([0.008]))
    parent = random_pose(np.random.default_rng(3))
    poses = [parent, parent @ joint.parent_from_child(np.array([0.008]))]
    q_before = np.array([[0.0, 0.0], [0.0, 0.0]])
    after = predicted(poses, poses, structures=structures, q_before=q_before)
    assert structures.arrays.q[1, 0] == pytest.approx(0.012)
    wanted = parent @ joint.parent_from_child(np.array([0.012]))
    assert after[1].distance_to(wanted) < 1e-9


def test_no_motion_is_none() -> None:
    pose = random_pose(np.random.default_rng(4)).matrix
    step = np.full(6, np.nan)
    relative_motion(pose, pose, step)
    assert np.abs(step).max() < 1e-12
