"""What the tracker says when it sees less: no depth, hidden parts, wrong frames, wrong names."""

import dataclasses

import numpy as np
import pytest

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.parameters import RegionParameters, TrackerParameters
from snapfit.tracking.result import Status
from snapfit.tracking.tracker import Tracker

HOME = Pose.from_rotation_translation(
    Pose.exp([0.5, 0.6, -0.3, 0, 0, 0]).rotation, (0.02, -0.01, 0.65)
)
EVERYWHERE = (slice(None), slice(None))


@pytest.fixture
def base(clamp):
    return clamp[0]


@pytest.fixture
def tracker(base, camera) -> Tracker:
    return create_tracker("icg", [base], camera)


def test_depth_all_zero_is_tracked_on_colour_alone_with_less_confidence(
    base, tracker, draw
) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    seen = tracker.track(draw([base], {base.name: HOME})).parts[0]
    blind = tracker.track(draw([base], {base.name: HOME}, depth="zero")).parts[0]
    assert blind.status is Status.TRACKED
    assert blind.camera_from_body.distance_to(HOME) < 0.003
    assert blind.confidence < 0.7 < seen.confidence


def test_a_frame_without_depth_is_tracked_on_colour_alone(base, tracker, draw) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    blind = tracker.track(draw([base], {base.name: HOME}, depth="none")).parts[0]
    assert blind.status is Status.TRACKED
    assert blind.camera_from_body.distance_to(HOME) < 0.003


def test_a_camera_without_depth_tracks_on_colour_alone(base, camera, draw) -> None:
    tracker = create_tracker("icg", [base], RgbdCamera(camera.color))
    frame = draw([base], {base.name: HOME}, depth="none")
    tracker.start(frame, {base.name: HOME})
    assert tracker.track(frame).parts[0].camera_from_body.distance_to(HOME) < 0.003


def test_a_covered_part_stays_where_it_was_and_says_so(base, tracker, draw) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    before = tracker.track(draw([base], {base.name: HOME})).parts[0]
    covered = draw([base], {base.name: HOME}, cover=(*EVERYWHERE, 0.4))
    for _ in range(30):
        hidden = tracker.track(covered).parts[0]
    assert hidden.status is Status.PREDICTED
    assert hidden.visibility == 0.0
    assert hidden.confidence < before.confidence / 2
    assert hidden.camera_from_body.distance_to(before.camera_from_body) < 1e-6
    again = tracker.track(draw([base], {base.name: HOME})).parts[0]
    assert again.status is Status.TRACKED


def test_half_a_part_behind_a_hand_keeps_its_pose(base, tracker, draw) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    half = draw([base], {base.name: HOME}, cover=(slice(None), slice(0, 650), 0.45))
    for _ in range(10):
        estimate = tracker.track(half).parts[0]
    assert estimate.status is Status.TRACKED
    assert 0.2 < estimate.visibility < 0.8
    assert estimate.camera_from_body.distance_to(HOME) < 0.002


def test_a_part_that_is_taken_away_is_lost_and_has_no_pose(base, tracker, draw) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    gone = draw([], {})
    statuses = [tracker.track(gone).parts[0] for _ in range(20)]
    assert statuses[-1].status is Status.LOST
    assert statuses[-1].camera_from_body is None
    assert statuses[-1].confidence == 0.0


def test_parts_that_were_not_started_are_searched(clamp, camera, draw) -> None:
    tracker = create_tracker("icg", clamp, camera)
    frame = draw(clamp[:1], {clamp[0].name: HOME})
    tracker.start(frame, {clamp[0].name: HOME})
    parts = tracker.track(frame).parts
    assert [part.status for part in parts] == [Status.TRACKED, Status.SEARCHING, Status.SEARCHING]
    assert parts[1].camera_from_body is None


def test_a_part_in_front_of_another_does_not_pull_at_it(clamp, camera, draw) -> None:
    behind, before = clamp[0], clamp[1]
    poses = {
        behind.name: HOME,
        before.name: Pose.from_rotation_translation(HOME.rotation, (0.05, 0.0, 0.55)),
    }
    tracker = create_tracker("icg", [behind, before], camera)
    frame = draw([behind, before], poses)
    tracker.start(frame, poses)
    for _ in range(10):
        result = tracker.track(frame)
    for estimate in result.parts:
        assert estimate.camera_from_body.distance_to(poses[estimate.part]) < 0.002
    assert result.parts[0].visibility < result.parts[1].visibility


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"color": np.zeros((480, 640, 3), dtype=np.uint8)}, "colour image is \\(480, 640, 3\\)"),
        ({"color": np.zeros((720, 1280, 3), dtype=np.float32)}, "float32"),
        ({"depth": np.zeros((100, 100), dtype=np.uint16)}, "depth image is \\(100, 100\\)"),
        ({"depth": np.zeros((720, 1280), dtype=np.uint8)}, "uint8"),
    ],
)
def test_a_frame_that_does_not_fit_is_refused_and_changes_nothing(
    base, tracker, draw, change: dict[str, np.ndarray], message: str
) -> None:
    good = draw([base], {base.name: HOME})
    tracker.start(good, {base.name: HOME})
    bad: Frame = dataclasses.replace(good, **change)
    with pytest.raises(FrameError, match=message):
        tracker.track(bad)
    assert tracker.track(good).parts[0].status is Status.TRACKED


def test_unknown_names_are_refused_with_the_known_ones(base, tracker, draw, camera) -> None:
    with pytest.raises(TrackingError, match=f"no part 'nope'.*{base.name}"):
        tracker.start(draw([base], {base.name: HOME}), {"nope": HOME})
    with pytest.raises(TrackingError, match=r"no method 'nope'; the methods are .*icg"):
        create_tracker("nope", [base], camera)
    with pytest.raises(TrackingError, match="no part to track"):
        create_tracker("icg", [], camera)
    with pytest.raises(TrackingError, match="same name"):
        create_tracker("icg", [base, base], camera)


def test_depth_alone_needs_a_depth_camera(base, camera) -> None:
    with pytest.raises(TrackingError, match="needs a depth camera"):
        Tracker(load_bodies([base]), RgbdCamera(camera.color), TrackerParameters(region=None))


def test_a_first_pose_behind_the_camera_is_refused(base, tracker, draw) -> None:
    frame = draw([base], {base.name: HOME})
    with pytest.raises(TrackingError, match=f"first pose of {base.name} is not in front"):
        tracker.start(frame, {base.name: Pose.identity()})


def test_a_lost_part_that_is_then_hidden_stays_lost(base, tracker, draw) -> None:
    tracker.start(draw([base], {base.name: HOME}), {base.name: HOME})
    for _ in range(20):
        tracker.track(draw([], {}))
    hidden = tracker.track(draw([], {}, cover=(*EVERYWHERE, 0.4))).parts[0]
    assert hidden.status is Status.LOST
    assert hidden.camera_from_body is None


def test_more_lines_than_a_view_has_are_refused(base, camera) -> None:
    parameters = TrackerParameters(region=RegionParameters(lines_max=600))
    with pytest.raises(TrackingError, match="a view has 300 at most"):
        Tracker(load_bodies([base]), camera, parameters)
