"""Errors of links: the joint's motion and the symmetries of both parts change nothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from snapfit.models.manifest import Joint, Link
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry, SymmetryAxis
from snapfit.tracking.assembly.link_error import LinkFit, LinkMeasure

Z_AXIS = SymmetryAxis(np.array([0.0, 0, 1]), np.zeros(3))
TILTED = SymmetryAxis(np.array([1.0, 2, 0.5]), np.array([0.01, -0.02, 0.005]))
QUARTERS = Symmetry(tuple(Z_AXIS.turn(math.pi / 2 * i) for i in (1, 2, 3)))
HALF = Symmetry((TILTED.turn(math.pi),))
JOINTS: list[dict[str, Any]] = [
    {"type": "fixed"},
    {"type": "revolute", "axis": (0, 0, 1)},
    {"type": "revolute", "axis": (0, 1, 1), "point_m": (0.03, 0, 0), "turn_deg": (-80, 60)},
    {"type": "prismatic", "axis": (1, 0, 0), "travel_m": (-0.04, 0.02)},
    {"type": "cylindrical", "axis": (0, 0, 1), "travel_m": (-0.04, 0.02)},
    {"type": "screw", "axis": (0, 0, 1), "pitch_m": 0.012, "travel_m": (-0.03, 0.02)},
]
SYMMETRIES = {
    "none": NO_SYMMETRY,
    "quarters": QUARTERS,
    "half": HALF,
    "axis": Symmetry((), Z_AXIS),
    "tilted": Symmetry((), TILTED),
    "cylinder": Symmetry((Pose.exp([math.pi, 0, 0, 0, 0, 0]),), Z_AXIS),
}


def link_of(values: dict[str, Any], rng: np.random.Generator) -> Link:
    goal = Pose.exp(rng.standard_normal(6) * (1, 1, 1, 0.05, 0.05, 0.05))
    joint = Joint.model_validate(values)
    return Link(parent="a", child="b", parent_from_child=goal, joint=joint)


def random_motion(symmetry: Symmetry, rng: np.random.Generator) -> Pose:
    motions = (Pose.identity(), *symmetry.motions)
    motion = motions[rng.integers(len(motions))]
    if symmetry.axis is None:
        return motion
    return motion @ symmetry.axis.turn(rng.uniform(-math.pi, math.pi))


def random_q(measure: LinkMeasure, rng: np.random.Generator) -> Array:
    low, high = np.clip(measure.joint.limits, -3, 3).T if measure.joint.n_dof else ([], [])
    return np.asarray(rng.uniform(low, high))


def settled(fit: LinkFit, measured: Pose) -> Pose:
    """The relative pose after the symmetries that the fit names."""
    return fit.parent_symmetry.inverse() @ measured @ fit.child_symmetry


def n_separate_turns(joint: dict[str, Any], child: str, parent: str) -> int:
    """Of the joint and both axes of symmetry; those on one line count once."""
    joint_turns = joint["type"] not in ("fixed", "prismatic")
    child_turns = SYMMETRIES[child].axis is not None
    is_same = joint.get("axis") == (0, 0, 1) and child in ("axis", "cylinder")
    n_turns = joint_turns + child_turns + (SYMMETRIES[parent].axis is not None)
    return n_turns - (is_same and joint_turns and child_turns)


@pytest.mark.parametrize("parent", ["none", "quarters", "axis"])
@pytest.mark.parametrize("child", SYMMETRIES)
@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: joint["type"])
def test_what_looks_the_same_fulfils_the_link(
    joint: dict[str, Any], child: str, parent: str
) -> None:
    rng = np.random.default_rng(7)
    symmetries = SYMMETRIES[child], SYMMETRIES[parent]
    for _ in range(8):
        measure = LinkMeasure(link_of(joint, rng), *symmetries)
        at_place = measure.joint.parent_from_child(random_q(measure, rng))
        own, others = (random_motion(symmetry, rng) for symmetry in symmetries)
        measured = others @ at_place @ own.inverse()
        fit = measure.fit(measured.matrix)
        assert not measure.is_far(measured.matrix, 1e-6)
        if n_separate_turns(joint, child, parent) < 2:
            assert fit.translation_m < 1e-9
            assert fit.rotation_rad < 1e-7
        there = measure.joint.parent_from_child(fit.q)
        assert there.distance_to(settled(fit, measured)) == pytest.approx(
            fit.translation_m, abs=1e-9
        )
        assert there.angle_to(settled(fit, measured)) == pytest.approx(fit.rotation_rad, abs=1e-7)


@pytest.mark.parametrize("child", ["none", "quarters", "axis"])
def test_an_error_is_measured_as_it_is(child: str) -> None:
    rng = np.random.default_rng(8)
    for joint in JOINTS:
        measure = LinkMeasure(link_of(joint, rng), SYMMETRIES[child])
        # Across the joint's axis and the axis of symmetry, as far as one of both is a line z.
        if joint.get("axis", (0, 0, 1)) != (0, 0, 1):
            continue
        error = Pose.exp([math.radians(8), 0, 0, 0, 0, 0])
        measured = measure.goal @ Pose.from_translation(0.004, 0.003, 0) @ error
        fit = measure.fit(measured.matrix)
        assert fit.translation_m == pytest.approx(0.005, abs=1e-4)
        assert math.degrees(fit.rotation_rad) == pytest.approx(8, abs=0.1)
        assert fit.is_within_tolerance
        assert fit.is_within(0.006, 0.2)
        assert not fit.is_within(0.004, 0.2)


def test_turns_that_cannot_be_seen_leave_a_screw_its_travel() -> None:
    joint = {"type": "screw", "axis": (0, 0, 1), "pitch_m": 0.012, "travel_m": (-0.03, 0.0)}
    measure = LinkMeasure(link_of(joint, np.random.default_rng(9)), SYMMETRIES["axis"])
    measured = measure.goal @ Pose.exp([0, 0, 1.234, 0, 0, -0.0075])
    fit = measure.fit(measured.matrix)
    assert fit.q[0] == pytest.approx(-0.0075 / 0.012 * 2 * math.pi)
    assert fit.rotation_rad < 1e-7
    assert measure.joint.parent_from_child(fit.q).angle_to(settled(fit, measured)) < 1e-7
    assert measure.fit_at_zero(measured.matrix).translation_m == pytest.approx(0.0075)
    beyond = measure.goal @ Pose.from_translation(0, 0, 0.004)
    assert measure.fit(beyond.matrix).translation_m == pytest.approx(0.004)


def test_at_zero_the_joint_is_rigid() -> None:
    measure = LinkMeasure(link_of(JOINTS[3], np.random.default_rng(10)), NO_SYMMETRY)
    measured = measure.goal @ Pose.from_translation(-0.03, 0, 0)
    assert measure.fit(measured.matrix).translation_m < 1e-9
    at_zero = measure.fit_at_zero(measured.matrix)
    assert at_zero.translation_m == pytest.approx(0.03)
    assert not at_zero.is_within_tolerance


def test_far_is_never_said_of_what_is_near() -> None:
    rng = np.random.default_rng(11)
    for joint in JOINTS:
        for child in SYMMETRIES.values():
            measure = LinkMeasure(link_of(joint, rng), child, QUARTERS)
            for _ in range(20):
                pose = measure.goal @ Pose.exp(rng.standard_normal(6) * (1, 1, 1, 0.06, 0.06, 0.06))
                if measure.is_far(pose.matrix, 0.03):
                    assert measure.fit(pose.matrix).translation_m > 0.03
    free = LinkMeasure(link_of(JOINTS[4] | {"travel_m": None}, rng), NO_SYMMETRY)
    assert not free.is_far(Pose.from_translation(9, 9, 9).matrix, 0.03)
