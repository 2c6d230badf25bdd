"""Joints: coordinates found again, limits kept, twists equal to what a small motion shows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from snapfit.models.asset import bundled_names, find_asset
from snapfit.models.errors import PoseError
from snapfit.models.joint import JointMotion, angles, rotations_about, turns_about
from snapfit.models.manifest import Joint, Link
from snapfit.models.pose import Array, Pose

N_RANDOM = 60
JOINTS: dict[str, dict[str, Any]] = {
    "fixed": {"type": "fixed"},
    "revolute": {"type": "revolute", "turn_deg": (-100, 150)},
    "revolute-free": {"type": "revolute"},
    "revolute-wide": {"type": "revolute", "turn_deg": (-236, 4)},
    "prismatic": {"type": "prismatic", "travel_m": (-0.04, 0.02)},
    "cylindrical": {"type": "cylindrical", "travel_m": (-0.04, 0.02), "turn_deg": (-90, 90)},
    "screw": {"type": "screw", "pitch_m": 0.015, "travel_m": (-0.04, 0.02)},
    "screw-left": {"type": "screw", "pitch_m": -0.02, "turn_deg": (-700, 360)},
}


def random_joint(kind: str, rng: np.random.Generator) -> JointMotion:
    values = dict(JOINTS[kind])
    if kind != "fixed":
        values |= {"axis": tuple(rng.standard_normal(3)), "point_m": tuple(rng.normal(0, 0.05, 3))}
    zero = Pose.exp(rng.standard_normal(6) * (1, 1, 1, 0.1, 0.1, 0.1))
    joint = Joint.model_validate(values)
    return JointMotion.of(Link(parent="a", child="b", parent_from_child=zero, joint=joint))


def random_q(joint: JointMotion, rng: np.random.Generator) -> Array:
    low, high = np.clip(joint.limits, -3.1, 3.1).T if joint.n_dof else np.zeros((2, 0))
    finite = np.isfinite(joint.limits).all(axis=1) if joint.n_dof else np.zeros(0, bool)
    low = np.where(finite, joint.limits[:, 0], low)
    high = np.where(finite, joint.limits[:, 1], high)
    q: Array = rng.uniform(low, high)
    return q


@pytest.mark.parametrize("kind", JOINTS)
def test_a_coordinate_is_found_again(kind: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(N_RANDOM):
        joint = random_joint(kind, rng)
        q = random_q(joint, rng)
        found, residual = joint.closest(joint.parent_from_child(q))
        again = joint.parent_from_child(found)
        np.testing.assert_allclose(again.matrix, joint.parent_from_child(q).matrix, atol=1e-9)
        if not kind.startswith("revolute"):
            np.testing.assert_allclose(found, q, atol=1e-8)
        assert residual.translation_m < 1e-9
        assert residual.rotation_rad < 1e-7


@pytest.mark.parametrize("kind", [kind for kind in JOINTS if kind != "fixed"])
def test_a_twist_is_the_derivative_of_the_motion(kind: str) -> None:
    rng = np.random.default_rng(2)
    for _ in range(N_RANDOM):
        joint = random_joint(kind, rng)
        q = random_q(joint, rng)
        for i in range(joint.n_dof):
            step = np.eye(joint.n_dof)[i] * 1e-6
            before, after = joint.parent_from_child(q - step), joint.parent_from_child(q + step)
            numeric = (before.inverse() @ after).log() / 2e-6
            np.testing.assert_allclose(joint.twists[i], numeric, atol=1e-5)


@pytest.mark.parametrize("kind", JOINTS)
def test_limits_are_kept_and_the_residual_is_what_remains(kind: str) -> None:
    rng = np.random.default_rng(3)
    for _ in range(N_RANDOM):
        joint = random_joint(kind, rng)
        pose = joint.zero @ Pose.exp(rng.standard_normal(6) * (1, 1, 1, 0.1, 0.1, 0.1))
        q, residual = joint.closest(pose)
        assert (q >= joint.limits[:, 0] - 1e-12).all()
        assert (q <= joint.limits[:, 1] + 1e-12).all()
        there = joint.parent_from_child(q)
        assert residual.translation_m == pytest.approx(there.distance_to(pose), abs=1e-9)
        assert residual.rotation_rad == pytest.approx(there.angle_to(pose), abs=1e-7)


@pytest.mark.parametrize("kind", ["revolute", "revolute-wide", "prismatic", "cylindrical"])
def test_no_other_coordinate_comes_nearer(kind: str) -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        joint = random_joint(kind, rng)
        pose = joint.zero @ Pose.exp(rng.standard_normal(6) * (1, 1, 1, 0.05, 0.05, 0.05))
        _, residual = joint.closest(pose)
        for _ in range(40):
            other = joint.parent_from_child(random_q(joint, rng))
            if kind == "prismatic":
                assert other.distance_to(pose) >= residual.translation_m - 1e-9
            else:
                assert other.angle_to(pose) >= residual.rotation_rad - 1e-7


def test_a_turn_beyond_its_limit_stops_at_the_nearer_one() -> None:
    joint = Joint(type="revolute", axis=(0, 0, 1), turn_deg=(-90, 30))
    motion = JointMotion.of(
        Link(parent="a", child="b", parent_from_child=Pose.identity(), joint=joint)
    )
    for turn_deg, expected_deg in [(50, 30), (-120, -90), (170, -90), (140, 30), (300, -60)]:
        pose = Pose.exp([0, 0, math.radians(turn_deg), 0, 0, 0])
        q, _ = motion.closest(pose)
        assert math.degrees(q[0]) == pytest.approx(expected_deg)


def test_a_screw_is_known_over_many_turns_by_its_travel() -> None:
    joint = Joint(type="screw", axis=(0, 0, 1), pitch_m=0.004, travel_m=(-0.03, 0.03))
    motion = JointMotion.of(
        Link(parent="a", child="b", parent_from_child=Pose.identity(), joint=joint)
    )
    for turns in (-7.3, -2.5, 0.0, 3.9, 7.1):
        q = np.array([2 * math.pi * turns])
        noisy = motion.parent_from_child(q) @ Pose.exp([0.01, 0, 0.02, 0, 0, 0.0012])
        found, residual = motion.closest(noisy)
        assert found[0] == pytest.approx(q[0], abs=0.1)
        assert residual.translation_m < 0.002


def test_a_turn_that_is_not_seen_leaves_the_travel() -> None:
    poses = Pose.from_translation(0, 0.001, -0.015).matrix[None]
    for kind, pitch_m, expected in [
        ("screw", -0.01, [3 * math.pi]),
        ("cylindrical", None, [0, -0.015]),
        ("prismatic", None, [-0.015]),
        ("revolute", None, [0]),
        ("fixed", None, []),
    ]:
        axis = None if kind == "fixed" else (0, 0, 1)
        joint = Joint.model_validate({"type": kind, "axis": axis, "pitch_m": pitch_m})
        motion = JointMotion.of(
            Link(parent="a", child="b", parent_from_child=Pose.identity(), joint=joint)
        )
        q = motion.coordinates(poses, turn_seen=False)
        np.testing.assert_allclose(q[0], expected, atol=1e-12)
        rotation, translation = motion.moved(q)
        there = Pose.from_rotation_translation(rotation[0], translation[0])
        np.testing.assert_allclose(there.matrix, motion.parent_from_child(q[0]).matrix, atol=1e-12)


def test_limits_that_exclude_each_other_are_refused() -> None:
    joint = Joint(
        type="screw", axis=(0, 0, 1), pitch_m=0.01, travel_m=(0.01, 0.02), turn_deg=(-90, 90)
    )
    link = Link(parent="base", child="bolt", parent_from_child=Pose.identity(), joint=joint)
    with pytest.raises(PoseError, match=r"'bolt' on 'base'.*turn_deg and travel_m exclude"):
        JointMotion.of(link)


def test_turns_and_angles_hold_at_a_half_turn() -> None:
    axis = np.array([0.6, 0.0, 0.8])
    turn = np.array([0.0, 1e-9, 1.0, math.pi - 1e-7, -2.0])
    np.testing.assert_allclose(turns_about(axis, rotations_about(axis, turn)), turn, atol=1e-12)
    np.testing.assert_allclose(angles(rotations_about(axis, turn)), np.abs(turn), atol=1e-12)


@pytest.mark.parametrize("name", bundled_names())
def test_every_bundled_joint_stands_at_zero_within_its_limits(name: str) -> None:
    links = [link for state in find_asset(name).states for link in state.links]
    assert links
    for link in links:
        motion = JointMotion.of(link)
        q, residual = motion.closest(link.parent_from_child)
        np.testing.assert_allclose(q, np.zeros(motion.n_dof), atol=1e-9)
        assert residual.translation_m < 1e-9
