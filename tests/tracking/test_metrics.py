import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.asset import Part
from snapfit.models.camera import AZURE_KINECT_720P
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry, SymmetryAxis
from snapfit.tracking.evaluation import PartEvaluation
from snapfit.tracking.metrics import (
    add_m,
    add_or_add_s_m,
    add_s_m,
    area_under_curve,
    mspd_px,
    mssd_m,
    quantile,
    recall,
    surface_points,
)
from snapfit.tracking.result import PartEstimate, Status

POINTS = np.random.default_rng(5).uniform(-0.05, 0.05, (200, 3))
TRUTH = Pose.exp([0.3, -0.2, 0.5, 0.02, -0.03, 0.6])
HALF_TURN = Pose.exp([0, 0, math.pi, 0, 0, 0])
SYMMETRIC = Symmetry((HALF_TURN,))

shifts = st.tuples(*[st.floats(-0.02, 0.02)] * 3)


@given(shifts)
def test_a_shift_is_its_own_length_in_add_and_mssd(shift: tuple[float, float, float]) -> None:
    estimate = Pose.from_translation(*shift) @ TRUTH
    length_m = float(np.linalg.norm(shift))
    assert add_m(POINTS, estimate, TRUTH) == pytest.approx(length_m, abs=1e-12)
    assert mssd_m(POINTS, estimate, TRUTH, NO_SYMMETRY) == pytest.approx(length_m, abs=1e-12)
    assert add_s_m(POINTS, estimate, TRUTH) <= length_m + 1e-12


def test_add_s_equals_the_search_through_all_pairs() -> None:
    estimate = TRUTH.perturbed([0.2, 0.1, -0.3, 0.01, 0.0, 0.02])
    ours, true = estimate.transform(POINTS), TRUTH.transform(POINTS)
    all_pairs = np.linalg.norm(ours[:, None] - true[None], axis=2).min(axis=1).mean()
    assert add_s_m(POINTS, estimate, TRUTH) == pytest.approx(float(all_pairs), rel=1e-9)


def test_a_symmetric_part_is_judged_by_add_s() -> None:
    points = np.concatenate([POINTS, HALF_TURN.transform(POINTS)])
    estimate = TRUTH @ HALF_TURN
    assert add_or_add_s_m(points, estimate, TRUTH, SYMMETRIC) == pytest.approx(0, abs=1e-9)
    assert add_or_add_s_m(points, estimate, TRUTH, NO_SYMMETRY) > 0.03
    assert mssd_m(points, estimate, TRUTH, SYMMETRIC) == pytest.approx(0, abs=1e-12)
    assert mspd_px(points, estimate, TRUTH, SYMMETRIC, AZURE_KINECT_720P) == pytest.approx(
        0, abs=1e-9
    )
    assert mspd_px(points, estimate, TRUTH, NO_SYMMETRY, AZURE_KINECT_720P) > 50


def test_a_continuous_axis_is_cut_finely_enough_for_mssd() -> None:
    axis = SymmetryAxis(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    estimate = TRUTH @ axis.turn(1.2345)
    assert mssd_m(POINTS, estimate, TRUTH, Symmetry(axis=axis)) < 0.0006


def test_a_shift_across_the_view_has_the_size_that_the_camera_gives_it() -> None:
    truth = Pose.from_translation(0, 0, 0.5)
    estimate = Pose.from_translation(0.01, 0, 0.5)
    flat = POINTS * (1, 1, 0)
    expected_px = 607.2 * 0.01 / 0.5
    assert mspd_px(flat, estimate, truth, NO_SYMMETRY, AZURE_KINECT_720P) == pytest.approx(
        expected_px
    )


@given(st.lists(st.floats(0, 0.3), min_size=1, max_size=20))
def test_the_area_is_that_under_the_recall(errors: list[float]) -> None:
    values = np.array(errors)
    thresholds = (np.arange(2000) + 0.5) / 2000 * 0.1
    sampled = np.mean([recall(values, threshold) for threshold in thresholds])
    assert area_under_curve(values, 0.1) == pytest.approx(sampled, abs=1e-3)


def test_no_estimate_is_a_failure() -> None:
    errors = np.array([0.0, 0.05, math.inf, math.inf])
    assert recall(errors, 0.1) == 0.5
    assert area_under_curve(errors, 0.1) == pytest.approx((1 + 0.5) / 4)
    assert quantile(errors, 0.5) == 0.05
    assert quantile(errors, 0.95) == math.inf
    assert math.isnan(recall(np.array([]), 0.1))
    assert math.isnan(quantile(np.array([]), 0.5))
    assert math.isnan(area_under_curve(np.array([]), 0.1))


def box_mesh() -> Mesh:
    box = trimesh.creation.box((0.04, 0.06, 0.1))
    return Mesh(box.vertices.astype(np.float32), box.faces.astype(np.int32))


def test_surface_points_lie_evenly_on_the_surface() -> None:
    points = surface_points(box_mesh(), 20_000, np.random.default_rng(1))
    half = np.array([0.02, 0.03, 0.05])
    on_face = np.isclose(np.abs(points), half, atol=1e-7)
    assert on_face.any(axis=1).all()
    assert (np.abs(points) <= half + 1e-7).all()
    areas = np.array([0.06 * 0.1, 0.04 * 0.1, 0.04 * 0.06])
    assert on_face.mean(axis=0) == pytest.approx(areas / areas.sum(), abs=0.01)
    top = points[on_face[:, 2] & (points[:, 2] > 0)]
    assert top.mean(axis=0) == pytest.approx((0, 0, 0.05), abs=0.001)
    again = surface_points(box_mesh(), 20_000, np.random.default_rng(1))
    np.testing.assert_array_equal(points, again)


def estimate_of(pose: Pose | None, status: Status = Status.TRACKED) -> PartEstimate:
    return PartEstimate("box", status, 0.8 if pose else 0.0, pose)


def test_an_evaluation_counts_and_judges() -> None:
    evaluation = PartEvaluation(Part("box", box_mesh(), symmetry=SYMMETRIC))
    truth = GroundTruth("0", {"box": TRUTH}, {"box": 0.9})
    shifted = Pose.from_translation(0.003, 0, 0.004) @ TRUTH @ HALF_TURN
    evaluation.add(estimate_of(shifted), truth)
    evaluation.add(estimate_of(TRUTH.perturbed([0.1, 0, 0, 0, 0, 0])), truth)
    evaluation.add(estimate_of(None, Status.LOST), truth)
    # Hidden, without truth, or of another part: counted, not judged.
    evaluation.add(estimate_of(None, Status.LOST), GroundTruth("1", {"box": TRUTH}, {"box": 0.4}))
    evaluation.add(estimate_of(TRUTH), None)
    evaluation.add(estimate_of(TRUTH), GroundTruth("2", {"lid": TRUTH}))
    assert (evaluation.n_frames, evaluation.n_tracked, evaluation.n_lost) == (6, 4, 2)
    assert evaluation.confidence == 0.8
    assert evaluation.n_judged == 3
    assert evaluation.translations_m == pytest.approx([0.005, 0, math.inf], abs=1e-9)
    assert evaluation.rotations_rad == pytest.approx([0, 0.1, math.inf], abs=1e-6)
    assert evaluation.translation_m(0.5) == pytest.approx(0.005)
    assert evaluation.rotation_rad(0.95) == math.inf
    assert evaluation.add_recall == pytest.approx(2 / 3)
