"""Several cameras on one bench: what one does not see, another does."""

import dataclasses

import numpy as np
import pytest

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.camera_view import RigCamera
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import TrackerParameters
from snapfit.tracking.result import Status
from snapfit.tracking.tracker import Tracker

HOME = Pose.from_rotation_translation(
    Pose.exp([0.5, 0.6, -0.3, 0, 0, 0]).rotation, (0.02, -0.01, 0.65)
)
MIDDLE = Pose.from_translation(0.0, 0.0, 0.65)
# The second camera looks at the same place, from 70 degrees to the left.
SIDE = MIDDLE @ Pose.exp([0, np.radians(70), 0, 0, 0, 0]) @ MIDDLE.inverse()
STEP = np.array([0.01, -0.02, 0.015, 0.003, 0.002, -0.003])
EVERYWHERE = (slice(None), slice(None), 0.35)


@pytest.fixture(scope="module")
def base(clamp):
    return clamp[0]


@pytest.fixture
def tracker(base, camera) -> Tracker:
    return create_tracker("icg", [base], camera, rig=[RigCamera(camera, SIDE)])


@pytest.fixture
def see(base, draw):
    """see(pose, cover=..., beside_cover=...): a frame of each camera."""

    def _see(pose, cover=None, beside_cover=None):
        first = draw([base], {base.name: pose}, cover=cover)
        return first, draw([base], {base.name: SIDE @ pose}, cover=beside_cover)

    return _see


def errors(estimate, truth: Pose) -> tuple[float, float]:
    pose = estimate.camera_from_body
    return pose.distance_to(truth), float(np.degrees(pose.angle_to(truth)))


def follow(tracker, base, see, n_frames=8, **covers):
    """Start in full view, then go on under covers; the last estimate and the truth."""
    pose = HOME
    first, beside = see(pose)
    others = [beside] * (len(tracker.cameras) - 1)
    tracker.start(first, {base.name: pose}, *others)
    for _ in range(n_frames):
        pose = pose.perturbed(STEP)
        first, beside = see(pose, **covers)
        result = tracker.track(first, *([beside] * len(others)))
    return result.parts[0], pose


def test_a_part_that_one_camera_does_not_see_is_tracked_by_the_other(
    base, tracker, camera, see
) -> None:
    for covers in ({"cover": EVERYWHERE}, {"beside_cover": EVERYWHERE}):
        estimate, truth = follow(tracker, base, see, **covers)
        distance_m, angle_deg = errors(estimate, truth)
        assert estimate.status is Status.TRACKED, covers
        assert estimate.visibility > 0.9, covers
        assert distance_m < 0.0015, covers
        assert angle_deg < 1.0, covers
    alone, truth = follow(create_tracker("icg", [base], camera), base, see, cover=EVERYWHERE)
    assert alone.status is Status.PREDICTED
    assert errors(alone, truth)[0] > 0.02


def test_a_part_that_no_camera_sees_stays_where_it_was(base, tracker, see) -> None:
    estimate, _ = follow(tracker, base, see, cover=EVERYWHERE, beside_cover=EVERYWHERE)
    assert estimate.status is Status.PREDICTED
    assert errors(estimate, HOME)[0] < 0.001


@pytest.mark.parametrize("missing", [0, 1])
def test_a_camera_without_a_frame_is_left_out(base, tracker, see, missing: int) -> None:
    pose = HOME
    first, beside = see(pose)
    tracker.start(first, {base.name: pose}, beside)
    for _ in range(4):
        pose = pose.perturbed(STEP)
        frames = list(see(pose))
        frames[missing] = None
        result = tracker.track(*frames)
        distance_m, angle_deg = errors(result.parts[0], pose)
        assert distance_m < 0.0015
        assert angle_deg < 1.0
    pose = pose.perturbed(STEP)
    assert errors(tracker.track(*see(pose)).parts[0], pose)[0] < 0.0015


def test_one_camera_of_a_rig_does_what_a_tracker_of_one_camera_does(
    base, tracker, camera, see
) -> None:
    alone = create_tracker("icg", [base], camera)
    first, _ = see(HOME)
    for each in (alone, tracker):
        each.start(first, {base.name: HOME.perturbed(0.3 * STEP)})
    pose = HOME
    for _ in range(3):
        pose = pose.perturbed(STEP)
        first, _ = see(pose)
        one, two = (each.track(first).parts[0] for each in (alone, tracker))
        assert np.array_equal(one.camera_from_body.matrix, two.camera_from_body.matrix)
        np.testing.assert_allclose(one.covariance, two.covariance)
        assert one.confidence == two.confidence
        assert one.visibility == two.visibility


def test_a_camera_that_starts_late_learns_the_colours_by_itself(base, tracker, see) -> None:
    tracker.start(see(HOME)[0], {base.name: HOME})
    for _ in range(3):
        tracker.track(*see(HOME))
    pose = HOME
    for _ in range(6):
        pose = pose.perturbed(STEP)
        estimate = tracker.track(*see(pose, cover=EVERYWHERE)).parts[0]
    assert estimate.status is Status.TRACKED
    assert estimate.confidence > 0.7
    assert errors(estimate, pose)[0] < 0.0015


def test_two_looks_at_a_part_leave_less_doubt_than_one(base, tracker, camera, see) -> None:
    alone, _ = follow(create_tracker("icg", [base], camera), base, see, n_frames=1)
    both, _ = follow(tracker, base, see, n_frames=1)
    assert np.linalg.det(both.covariance) < 0.25 * np.linalg.det(alone.covariance)
    # Along the line of sight one camera knows least, and another helps most.
    assert (np.linalg.eigvalsh(both.covariance) <= np.linalg.eigvalsh(alone.covariance)).all()


def test_cameras_may_differ(base, camera, draw) -> None:
    small = RgbdCamera(camera.color.scaled(0.5))
    tracker = create_tracker("icg", [base], camera, rig=[RigCamera(small, SIDE)])

    def see(pose, cover=None, beside_cover=None):
        beside = draw([base], {base.name: SIDE @ pose}, depth="none", cover=beside_cover)
        color = np.ascontiguousarray(beside.color[::2, ::2])
        first = draw([base], {base.name: pose}, cover=cover)
        return first, dataclasses.replace(beside, color=color)

    estimate, truth = follow(tracker, base, see, n_frames=5, cover=EVERYWHERE)
    assert estimate.status is Status.TRACKED
    assert errors(estimate, truth)[0] < 0.006


@pytest.mark.parametrize("in_front", [False, True])
def test_an_attempt_changes_nothing(base, camera, see, in_front) -> None:
    bodies = load_bodies([base])
    optimiser = Optimiser(bodies, camera, TrackerParameters(), [RigCamera(camera, SIDE)])
    optimiser.place(0, HOME)
    optimiser.see(*see(HOME))
    optimiser.refine()
    optimiser.weigh()
    pose, evidence = optimiser.pose(0), optimiser.evidence(0)
    support, likelihood = optimiser.support.copy(), optimiser.likelihoods[0]
    tried = optimiser.attempt(0, HOME.perturbed(5 * STEP), in_front=in_front)
    assert tried.evidence.lines > 0
    assert np.array_equal(optimiser.pose(0).matrix, pose.matrix)
    assert optimiser.evidence(0) == evidence
    assert np.array_equal(optimiser.support, support)
    assert optimiser.likelihoods[0] == likelihood
    assert optimiser.is_active(0)


def test_frames_that_do_not_fit_are_left_out_and_told(base, tracker, see) -> None:
    first, beside = see(HOME)
    tracker.start(first, {base.name: HOME}, beside)
    cut = dataclasses.replace(beside, name="cut", color=beside.color[::2])
    result = tracker.track(first, cut)
    assert [error.frame for error in result.left_out] == ["cut"]
    assert "the camera's is (720, 1280, 3)" in str(result.left_out[0])
    assert errors(result.parts[0], HOME)[0] < 0.001
    assert tracker.track(cut, beside).left_out[0].frame == "cut"
    assert tracker.track(first, beside).left_out == ()
    with pytest.raises(FrameError, match="frame cut: the colour image"):
        tracker.track(cut, cut)
    with pytest.raises(TrackingError, match="no camera has a frame"):
        tracker.track(None, None)
    with pytest.raises(TrackingError, match="3 frames for 2 camera"):
        tracker.track(first, beside, beside)
    with pytest.raises(TrackingError, match="3 frames for 2 camera"):
        tracker.start(first, {base.name: HOME}, beside, beside)
