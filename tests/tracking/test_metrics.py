import math
from collections.abc import Sequence

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
    add_s_m,
    area_under_curve,
    average_recall,
    model_vertices,
    mspd_px,
    mssd_m,
    quantile,
    recall,
    symmetry_motions,
)
from snapfit.tracking.result import PartEstimate, Status

POINTS = np.random.default_rng(5).uniform(-0.05, 0.05, (60, 3))
DIAMETER_M = 0.15
TRUTH = Pose.exp([0.3, -0.2, 0.5, 0.02, -0.03, 0.6])
HALF_TURN = Pose.exp([0, 0, math.pi, 0, 0, 0])
SYMMETRIC = Symmetry((HALF_TURN,))
OFF_CENTRE = SymmetryAxis(np.array([1.0, 2.0, -0.5]), np.array([0.01, -0.02, 0.005]))
FLIP = Pose.exp([math.pi, 0, 0, 0, 0, 0])
UPRIGHT = SymmetryAxis(np.array([0.0, 0.0, 1.0]), np.zeros(3))

SYMMETRIES = {
    "none": NO_SYMMETRY,
    "half turn": SYMMETRIC,
    "three motions": Symmetry((HALF_TURN, FLIP, HALF_TURN @ FLIP)),
    "axis": Symmetry(axis=OFF_CENTRE),
    "axis and flip": Symmetry((FLIP,), UPRIGHT),
}

# What follows is written from the published formulae, point by point, in plain Python.


def moved(pose: Pose, point: Sequence[float]) -> list[float]:
    m = pose.matrix.tolist()
    return [
        m[r][0] * point[0] + m[r][1] * point[1] + m[r][2] * point[2] + m[r][3] for r in range(3)
    ]


def plain_add_m(estimate: Pose, truth: Pose) -> float:
    """Mean over x of |(R^ x + t^) - (R x + t)|."""
    total = 0.0
    for x in POINTS.tolist():
        total += math.dist(moved(estimate, x), moved(truth, x))
    return total / len(POINTS)


def plain_adi_m(estimate: Pose, truth: Pose) -> float:
    """Mean over x1 of the least over x2 of |(R x1 + t) - (R^ x2 + t^)|."""
    total = 0.0
    for x1 in POINTS.tolist():
        total += min(math.dist(moved(truth, x1), moved(estimate, x2)) for x2 in POINTS.tolist())
    return total / len(POINTS)


def plain_motions(symmetry: Symmetry) -> list[Pose]:
    """All of S_M: every discrete motion with every one of ceil(pi / 0.01) turns of the axis."""
    discrete = [Pose.identity(), *symmetry.motions]
    if symmetry.axis is None:
        return discrete
    n_angles = math.ceil(math.pi / 0.01)
    a, p = symmetry.axis.direction, symmetry.axis.point_m
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    turns = []
    for i in range(n_angles):
        angle = 2 * math.pi * i / n_angles
        r = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        turns.append(Pose.from_rotation_translation(r, p - r @ p))
    return [turn @ motion for turn in turns for motion in discrete]


def plain_mssd_m(estimate: Pose, truth: Pose, symmetry: Symmetry) -> float:
    """Least over S of the largest over x of |(R^ x + t^) - (R S x + t)|."""
    least = math.inf
    for motion in plain_motions(symmetry):
        largest = 0.0
        for x in POINTS.tolist():
            largest = max(largest, math.dist(moved(estimate, x), moved(truth @ motion, x)))
        least = min(least, largest)
    return least


def plain_mspd_px(estimate: Pose, truth: Pose, symmetry: Symmetry) -> float:
    """The same with everything projected into the image."""

    def projected(pose: Pose, point: Sequence[float]) -> tuple[float, float]:
        x, y, z = moved(pose, point)
        return 607.2 * x / z + 639.2, 607.2 * y / z + 364.8

    least = math.inf
    for motion in plain_motions(symmetry):
        largest = 0.0
        for x in POINTS.tolist():
            largest = max(largest, math.dist(projected(estimate, x), projected(truth @ motion, x)))
        least = min(least, largest)
    return least


def random_pair(seed: int) -> tuple[Pose, Pose]:
    """A true pose before the camera, and an estimate: near, or anywhere."""
    rng = np.random.default_rng(seed)
    truth = Pose.exp([*rng.uniform(-2, 2, 3), 0, 0, 0])
    truth = Pose.from_translation(*rng.uniform([-0.2, -0.2, 0.5], [0.2, 0.2, 1])) @ truth
    size = (0.05, 3.0)[seed % 2]
    return truth.perturbed(rng.uniform(-size, size, 6) * [1, 1, 1, 0.05, 0.05, 0.05]), truth


@pytest.mark.parametrize("seed", range(20))
def test_add_and_add_s_are_those_of_the_formulae(seed: int) -> None:
    estimate, truth = random_pair(seed)
    assert add_m(POINTS, estimate, truth) == pytest.approx(plain_add_m(estimate, truth), abs=1e-9)
    assert add_s_m(POINTS, estimate, truth) == pytest.approx(plain_adi_m(estimate, truth), abs=1e-9)


@pytest.mark.parametrize("name", SYMMETRIES)
@pytest.mark.parametrize("seed", range(4))
def test_mssd_and_mspd_are_those_of_the_formulae(seed: int, name: str) -> None:
    estimate, truth = random_pair(seed)
    symmetry = SYMMETRIES[name]
    motions = symmetry_motions(symmetry, DIAMETER_M)
    assert mssd_m(POINTS, estimate, truth, motions) == pytest.approx(
        plain_mssd_m(estimate, truth, symmetry), abs=1e-9
    )
    assert mspd_px(POINTS, estimate, truth, motions, AZURE_KINECT_720P) == pytest.approx(
        plain_mspd_px(estimate, truth, symmetry), abs=1e-6
    )


@pytest.mark.parametrize("seed", range(10))
def test_rotation_and_translation_errors_are_the_papers(seed: int) -> None:
    estimate, truth = random_pair(seed)
    cosine = (np.trace(estimate.rotation @ np.linalg.inv(truth.rotation)) - 1) / 2
    assert truth.angle_to(estimate) == pytest.approx(math.acos(cosine), abs=1e-6)
    assert truth.distance_to(estimate) == pytest.approx(
        math.dist(estimate.translation, truth.translation), abs=1e-12
    )


def test_the_symmetries_are_cut_as_finely_as_in_bop() -> None:
    assert len(symmetry_motions(NO_SYMMETRY, DIAMETER_M)) == 1
    assert len(symmetry_motions(Symmetry(axis=UPRIGHT), DIAMETER_M)) == 315
    assert len(symmetry_motions(Symmetry((FLIP,), UPRIGHT), 0.021)) == 630


shifts = st.tuples(*[st.floats(-0.02, 0.02)] * 3)


@given(shifts)
def test_a_shift_is_its_own_length_in_add_and_mssd(shift: tuple[float, float, float]) -> None:
    estimate = Pose.from_translation(*shift) @ TRUTH
    length_m = float(np.linalg.norm(shift))
    motions = symmetry_motions(NO_SYMMETRY, DIAMETER_M)
    assert add_m(POINTS, estimate, TRUTH) == pytest.approx(length_m, abs=1e-12)
    assert mssd_m(POINTS, estimate, TRUTH, motions) == pytest.approx(length_m, abs=1e-12)
    assert add_s_m(POINTS, estimate, TRUTH) <= length_m + 1e-12


def test_a_pose_that_looks_the_same_is_no_error() -> None:
    points = np.concatenate([POINTS, HALF_TURN.transform(POINTS)])
    estimate = TRUTH @ HALF_TURN
    motions = symmetry_motions(SYMMETRIC, DIAMETER_M)
    assert add_s_m(points, estimate, TRUTH) == pytest.approx(0, abs=1e-9)
    assert add_m(points, estimate, TRUTH) > 0.03
    assert mssd_m(points, estimate, TRUTH, motions) == pytest.approx(0, abs=1e-12)
    assert mspd_px(points, estimate, TRUTH, motions, AZURE_KINECT_720P) == pytest.approx(
        0, abs=1e-9
    )
    assert mspd_px(points, estimate, TRUTH, motions[:1], AZURE_KINECT_720P) > 50


def test_behind_the_camera_nothing_can_be_projected() -> None:
    motions = symmetry_motions(NO_SYMMETRY, DIAMETER_M)
    behind = Pose.from_translation(0, 0, -0.6)
    assert mspd_px(POINTS, behind, TRUTH, motions, AZURE_KINECT_720P) == math.inf


@given(st.lists(st.floats(0, 0.3), min_size=1, max_size=20))
def test_the_area_is_the_papers_score_and_that_under_the_recall(errors: list[float]) -> None:
    values = np.array(errors)
    paper = sum(max(1 - error / 0.1, 0) for error in errors) / len(errors)
    assert area_under_curve(values, 0.1) == pytest.approx(paper, abs=1e-12)
    thresholds = (np.arange(2000) + 0.5) / 2000 * 0.1
    assert average_recall(values, thresholds) == pytest.approx(paper, abs=1e-3)


def test_no_estimate_is_a_failure() -> None:
    errors = np.array([0.0, 0.05, math.inf, math.inf])
    assert recall(errors, 0.1) == 0.5
    assert area_under_curve(errors, 0.1) == pytest.approx((1 + 0.5) / 4)
    assert average_recall(errors, np.array([0.02, 0.1])) == pytest.approx((0.25 + 0.5) / 2)
    assert quantile(errors, 0.5) == 0.05
    assert quantile(errors, 0.95) == math.inf
    assert math.isnan(recall(np.array([]), 0.1))
    assert math.isnan(quantile(np.array([]), 0.5))
    assert math.isnan(area_under_curve(np.array([]), 0.1))


def box_mesh() -> Mesh:
    box = trimesh.creation.box((0.04, 0.06, 0.1))
    return Mesh(box.vertices.astype(np.float32), box.faces.astype(np.int32))


def test_a_small_mesh_is_judged_by_all_its_vertices() -> None:
    vertices = box_mesh().vertices.astype(np.float64)
    taken = model_vertices(box_mesh())
    assert sorted(map(tuple, taken)) == sorted(map(tuple, vertices))


def test_of_a_large_mesh_the_same_vertices_are_drawn_every_time() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    stretched = sphere.vertices.astype(np.float32) * np.array([1, 2, 3], np.float32)
    mesh = Mesh(stretched, sphere.faces.astype(np.int32))
    taken = model_vertices(mesh, 100)
    np.testing.assert_array_equal(taken, model_vertices(mesh, 100))
    every = {tuple(vertex) for vertex in mesh.vertices.astype(np.float64)}
    assert len(taken) == len({tuple(vertex) for vertex in taken} & every) == 100
    assert len(model_vertices(mesh, None)) == len(mesh.vertices)
    distances = np.linalg.norm(taken - mesh.center_m, axis=1)
    assert (np.diff(distances) <= 0).all()


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
    assert evaluation.adds_m[0] == pytest.approx(0.005, abs=1e-6)
    assert evaluation.translation_m(0.5) == pytest.approx(0.005)
    assert evaluation.rotation_rad(0.95) == math.inf
    assert evaluation.add_recall == pytest.approx(2 / 3)
