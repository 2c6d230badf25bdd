import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.errors import PoseError
from snapfit.models.pose import Pose
from snapfit.models.symmetry import (
    NO_SYMMETRY,
    Symmetry,
    SymmetryAxis,
    distance_modulo_symmetry,
    mean_distance_modulo_symmetry,
)

AXIS = SymmetryAxis(np.array([0.0, 0.0, 2.0]), np.array([0.02, -0.01, 0.0]))
FLIP = Pose.exp([math.pi, 0, 0, 0, 0, 0])
CYLINDER = Symmetry((FLIP,), SymmetryAxis(np.array([0.0, 0.0, 1.0]), np.zeros(3)))

angles = st.floats(-math.pi, math.pi)
numbers = st.floats(-1, 1)
poses = st.builds(lambda *xi: Pose.exp(xi), *[numbers] * 6)


@given(poses, angles)
def test_a_turn_about_the_axis_is_no_error(pose: Pose, angle: float) -> None:
    turned = pose @ AXIS.turn(angle)
    translation_m, rotation_rad = distance_modulo_symmetry(turned, pose, Symmetry(axis=AXIS))
    assert translation_m == pytest.approx(0, abs=1e-9)
    assert rotation_rad == pytest.approx(0, abs=1e-7)


@given(poses, angles, st.sampled_from([Pose.identity(), FLIP]))
def test_axis_and_flip_together_are_no_error(pose: Pose, angle: float, motion: Pose) -> None:
    assert CYLINDER.axis is not None
    same = pose @ motion @ CYLINDER.axis.turn(angle)
    assert distance_modulo_symmetry(same, pose, CYLINDER) == pytest.approx((0, 0), abs=1e-7)


@given(poses, poses)
def test_the_closed_form_is_not_beaten_by_any_sampled_turn(a: Pose, b: Pose) -> None:
    _, rotation_rad = distance_modulo_symmetry(a, b, Symmetry(axis=AXIS))
    sampled = [a.angle_to(b @ AXIS.turn(angle)) for angle in np.linspace(0, 2 * math.pi, 61)]
    assert rotation_rad <= min(sampled) + 1e-7
    assert rotation_rad >= min(sampled) - math.pi / 60


@given(poses, st.floats(0.01, 1.5), angles)
def test_a_tilt_of_the_axis_is_the_error_that_remains(
    pose: Pose, tilt: float, angle: float
) -> None:
    axis = SymmetryAxis(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    tilted = pose @ Pose.exp([tilt, 0, 0, 0, 0, 0]) @ axis.turn(angle)
    _, rotation_rad = distance_modulo_symmetry(pose, tilted, Symmetry(axis=axis))
    assert rotation_rad == pytest.approx(tilt, abs=1e-6)


def test_without_symmetry_the_errors_are_the_papers() -> None:
    a, b = Pose.identity(), Pose.exp([0, 0, 0.3, 0, 0, 0.0]) @ Pose.from_translation(0.03, 0, 0.04)
    assert distance_modulo_symmetry(a, b, NO_SYMMETRY) == pytest.approx((0.05, 0.3))


def test_the_mean_distance_takes_the_symmetry_out() -> None:
    rng = np.random.default_rng(3)
    half = rng.uniform(-0.05, 0.05, (50, 3))
    points = np.concatenate([half, FLIP.transform(half)])
    pose = Pose.from_translation(0, 0, 0.5)
    flipped = pose @ FLIP
    assert mean_distance_modulo_symmetry(points, pose, flipped, Symmetry((FLIP,))) == pytest.approx(
        0, abs=1e-12
    )
    assert mean_distance_modulo_symmetry(points, pose, flipped, NO_SYMMETRY) > 0.03
    moved = Pose.from_translation(0.01, 0, 0) @ flipped
    assert mean_distance_modulo_symmetry(points, pose, moved, Symmetry((FLIP,))) == pytest.approx(
        0.01
    )


def test_a_continuous_axis_is_sampled_finely_enough() -> None:
    motions = Symmetry(axis=AXIS).sampled(step_m=0.001, radius_m=0.05)
    arc_m = 0.05 * motions[0].angle_to(motions[1])
    assert 0.0009 < arc_m <= 0.001
    np.testing.assert_allclose(motions[0].matrix, np.eye(4), atol=1e-15)


def test_bop_symmetries_come_in_millimetres() -> None:
    matrix = np.eye(4)
    matrix[:3, :3] = FLIP.rotation
    matrix[1, 3] = 30.0
    info = {
        "diameter": 100.0,
        "symmetries_discrete": [matrix.ravel().tolist()],
        "symmetries_continuous": [{"axis": [0, 1, 0], "offset": [10, 0, 0]}],
    }
    symmetry = Symmetry.from_bop(info)
    assert symmetry.kind == "axis + discrete"
    assert symmetry.motions[0].translation[1] == pytest.approx(0.03)
    assert symmetry.axis is not None
    assert symmetry.axis.point_m == pytest.approx((0.01, 0, 0))
    assert Symmetry.from_bop({"diameter": 100.0}).is_none


@pytest.mark.parametrize("direction", [(0, 0, 0), (0, 0, math.nan)])
def test_an_axis_needs_a_direction(direction: tuple[float, float, float]) -> None:
    with pytest.raises(PoseError, match="symmetry axis"):
        SymmetryAxis(np.array(direction), np.zeros(3))
