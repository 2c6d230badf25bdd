"""Parts are found by themselves, again after they were lost, and never by believing a detector."""

import threading
import time
from collections.abc import Collection
from dataclasses import replace
from typing import ClassVar

import pytest
from patience import within

from snapfit.models.asset import find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.catch_up import CatchUpThread, ImmediateCatchUp
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import DelayedLookout, LookoutThread
from snapfit.tracking.finding.paper_reinit import PaperReinitialisation
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.result import Status
from snapfit.tracking.tracker import Tracker

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
TURN = Pose.exp([0.5, 0.6, -0.3, 0, 0, 0])
HERE = Pose.from_translation(0.08, -0.01, 0.65) @ TURN
THERE = Pose.from_translation(-0.12, 0.0, 0.65) @ TURN
OFF = [0.05, -0.06, 0.04, 0.006, -0.005, 0.006]


class FakeFinder:
    """Says what it was told, a little wrong."""

    def __init__(self, poses: dict[str, Pose], score: float = 0.9) -> None:
        self.names = tuple(poses)
        self.poses, self.score = poses, score
        self.asked: list[tuple[str, ...]] = []

    def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
        del frame
        self.asked.append(tuple(wanted))
        poses = self.poses.items()
        return [Hypothesis(n, pose.perturbed(OFF), self.score) for n, pose in poses if n in wanted]


class BrokenFinder:
    names = ("jaw",)

    def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
        del frame, wanted
        raise TrackingError("the network is made of cheese")


@pytest.fixture(scope="module")
def parts():
    clamp = find_asset("hobby-corner-clamp").tracked_parts
    return [clamp[1], replace(clamp[1], name="twin")]


def tracker_of(parts, finder, delay_frames: int = 2) -> SelfStartingTracker:
    tracker = create_tracker("gbot-without-graph", parts, CAMERA)
    return SelfStartingTracker(tracker, parts, DelayedLookout(finder, delay_frames))


def test_parts_start_by_themselves(parts, draw) -> None:
    poses = {"jaw": HERE, "twin": THERE}
    tracker = tracker_of(parts, FakeFinder(poses))
    results = [tracker.track(draw(parts, poses)) for _ in range(4)]
    assert {each.status for each in results[0].parts} == {Status.SEARCHING}
    assert all(each.camera_from_body is None for each in results[0].parts)
    for each in results[-1].parts:
        assert each.status is Status.TRACKED
        assert each.camera_from_body.distance_to(poses[each.part]) < 0.002


def test_twins_share_what_a_detector_takes_for_one_of_them(parts, draw) -> None:
    class OneClass(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            del frame, wanted
            return [Hypothesis("jaw", pose.perturbed(OFF), 0.9) for pose in (HERE, THERE)]

    tracker = tracker_of(parts, OneClass({"jaw": HERE, "twin": THERE}))
    poses = {"jaw": HERE, "twin": THERE}
    results = [tracker.track(draw(parts, poses)) for _ in range(4)]
    places = [each.camera_from_body for each in results[-1].parts]
    for place in (HERE, THERE):
        assert min(pose.distance_to(place) for pose in places) < 0.002


def test_a_find_on_the_bare_wall_is_dropped_again(parts, draw) -> None:
    wall = Pose.from_translation(0.2, 0.1, 0.5) @ TURN
    finder = FakeFinder({"jaw": wall})
    tracker = tracker_of(parts[:1], finder)
    frame = draw(parts[:1], {"jaw": HERE})
    results = [tracker.track(frame) for _ in range(8)]
    assert len(finder.asked) >= 2
    assert results[-1].parts[0].status is Status.SEARCHING


def test_a_part_that_moves_while_it_is_looked_for_starts_where_it_is_now(parts, draw) -> None:
    def at(number: int) -> dict[str, Pose]:
        return {"jaw": Pose.from_translation(0.004 * number, 0.0, 0.0) @ THERE}

    class Watching(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            self.poses = at(int(frame.name))
            return super().find(frame, wanted)

    finder = Watching(at(0))
    tracker = SelfStartingTracker(
        create_tracker("gbot-without-graph", parts[:1], CAMERA),
        parts[:1],
        DelayedLookout(finder, 15),
        catch_up=ImmediateCatchUp(Tracker(load_bodies(parts[:1]), CAMERA)),
    )
    for number in range(18):
        frame = draw(parts[:1], at(number), name=str(number))
        estimate = tracker.track(frame).parts[0]
    assert len(finder.asked) >= 1
    assert estimate.status is Status.TRACKED
    assert estimate.camera_from_body.distance_to(at(17)["jaw"]) < 0.002


def test_a_part_that_was_lost_is_tried_out_where_it_has_gone_since(parts, draw) -> None:
    """It comes out of a hand elsewhere, and moves on while it is looked for."""

    def at(number: int) -> dict[str, Pose]:
        if number < 0:
            return {"jaw": THERE}
        gone = Pose.from_translation(0.04 + 0.006 * number, 0.1, -0.02) @ THERE
        return {"jaw": gone @ Pose.exp([0.0, 1.2, 0.4, 0, 0, 0])}

    class Watching(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            found = super().find(frame, wanted) if int(frame.name) >= 0 else []
            pose = at(int(frame.name))["jaw"]
            return [replace(each, camera_from_body=pose, is_refined=True) for each in found]

    tracker = SelfStartingTracker(
        create_tracker("gbot-without-graph", parts[:1], CAMERA),
        parts[:1],
        DelayedLookout(Watching({"jaw": THERE}), 15),
        catch_up=ImmediateCatchUp(Tracker(load_bodies(parts[:1]), CAMERA)),
    )
    tracker.start(draw(parts[:1], {"jaw": THERE}), {"jaw": THERE})
    u, v = CAMERA.color.project(THERE.translation[None])[0].astype(int)
    cover = (slice(v - 130, v + 130), slice(u - 130, u + 130), 0.4)
    for number in range(-16, 0):
        hidden = draw(parts[:1], at(number), cover=cover, name=str(number))
        tracker.track(hidden if number >= -12 else draw(parts[:1], at(number), name=str(number)))
    for number in range(34):
        frame = draw(parts[:1], at(number), name=str(number))
        said = tracker.track(frame).parts[0]
    assert said.status is Status.TRACKED
    assert said.camera_from_body.distance_to(at(33)["jaw"]) < 0.002


def test_after_a_knock_parts_are_found_where_they_are_now(parts, draw) -> None:
    before = {"jaw": HERE, "twin": THERE}
    knock = Pose.from_translation(0.03, 0.09, 0.02) @ Pose.exp([0, 0, 0.5, 0, 0, 0])
    after = {name: knock @ pose for name, pose in before.items()}
    finder = FakeFinder(before)
    tracker = tracker_of(parts, finder)
    tracker.start(draw(parts, before), before)
    for _ in range(3):
        tracker.track(draw(parts, before))
    finder.poses = after
    frame = draw(parts, after)
    results = [tracker.track(frame) for _ in range(14)]
    for each in results[-1].parts:
        assert each.camera_from_body.distance_to(after[each.part]) < 0.002, each


def test_a_wrong_find_costs_nothing_where_all_is_seen(parts, draw) -> None:
    poses = {"jaw": HERE, "twin": THERE}
    wrong = {name: Pose.from_translation(0.02, 0.0, -0.05) @ pose for name, pose in poses.items()}
    finder = FakeFinder(wrong, score=1.0)
    tracker = tracker_of(parts, finder)
    tracker.start(draw(parts, poses), poses)
    frame = draw(parts, poses)
    for _ in range(14):
        result = tracker.track(frame)
        for each in result.parts:
            assert each.camera_from_body.distance_to(poses[each.part]) < 0.002
    assert finder.asked


def test_the_published_rule_believes_the_detector(parts, draw) -> None:
    poses = {"jaw": HERE}
    finder = FakeFinder({"jaw": Pose.from_translation(0.08, 0, 0) @ HERE})
    tracker = create_tracker("gbot-without-graph", parts[:1], CAMERA)
    paper = PaperReinitialisation(tracker, finder)
    frame = draw(parts[:1], poses)
    paper.start(frame, poses)
    distances = [paper.track(frame).parts[0].camera_from_body.distance_to(HERE) for _ in range(10)]
    assert max(distances[:9]) < 0.002
    assert distances[9] > 0.02
    assert len(finder.asked) == 1


def test_a_finder_that_fails_is_told_and_tracking_goes_on(parts, draw, caplog) -> None:
    lookout = LookoutThread(BrokenFinder())
    tracker = SelfStartingTracker(
        create_tracker("gbot-without-graph", parts[:1], CAMERA), parts[:1], lookout
    )
    frame = draw(parts[:1], {"jaw": HERE})
    until_s = time.monotonic() + within(60)
    try:
        while lookout.account.failed < 3:
            assert tracker.track(frame).parts[0].status is Status.SEARCHING
            assert time.monotonic() < until_s
            time.sleep(0.001)
    finally:
        tracker.close()
    assert "made of cheese" in caplog.text


def test_tracking_does_not_wait_for_a_finder_that_takes_long(parts, draw) -> None:
    class Slow(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            begun.set()
            assert may_end.wait(within(60))
            return super().find(frame, wanted)

    begun, may_end = threading.Event(), threading.Event()
    poses = {"jaw": HERE}
    tracker = SelfStartingTracker(
        create_tracker("gbot-without-graph", parts[:1], CAMERA),
        parts[:1],
        LookoutThread(Slow(poses)),
        catch_up=CatchUpThread(Tracker(load_bodies(parts[:1]), CAMERA)),
    )
    frame = draw(parts[:1], poses)
    try:
        assert tracker.track(frame).parts[0].status is Status.SEARCHING
        assert begun.wait(within(60))
        statuses = {tracker.track(frame).parts[0].status for _ in range(30)}
        assert statuses == {Status.SEARCHING}
        may_end.set()
        until_s = time.monotonic() + within(60)
        while (estimate := tracker.track(frame).parts[0]).status is Status.SEARCHING:
            assert time.monotonic() < until_s
            time.sleep(0.01)
    finally:
        may_end.set()
        tracker.close()
    assert estimate.camera_from_body.distance_to(HERE) < 0.002
    assert (tracker.account.started, tracker.account.dropped) == (1, 0)


@pytest.mark.parametrize(
    ("error", "told"),
    [(TrackingError("no keypoints"), "no keypoints"), (ZeroDivisionError("oh"), "Traceback")],
)
def test_looks_that_fail_are_counted_and_told_once(draw, parts, caplog, error, told) -> None:
    class Failing(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            del frame, wanted
            raise error

    lookout = LookoutThread(Failing({"jaw": HERE}))
    frame = draw(parts[:1], {"jaw": HERE})
    for _ in range(3):
        assert lookout.offer(frame, ["jaw"])
        until_s = time.monotonic() + within(60)
        while (found := lookout.take()) is None:
            assert time.monotonic() < until_s
            time.sleep(0.01)
        assert found.hypotheses == ()
    lookout.close()
    account = lookout.account
    assert (account.looks, account.failed, account.found) == (3, 3, 0)
    assert str(error) in account.last_problem
    assert told in caplog.text
    assert caplog.text.count("looking for parts failed") == 1


def test_what_a_finder_rejects_is_counted(draw, parts) -> None:
    class Choosy(FakeFinder):
        rejected: ClassVar[dict[str, int]] = {"few_inliers": 2}

    lookout = DelayedLookout(Choosy({"jaw": HERE}), 1)
    assert lookout.offer(draw(parts[:1], {"jaw": HERE}), ["jaw"])
    assert (lookout.account.looks, lookout.account.found) == (1, 1)
    assert lookout.account.rejected == {"few_inliers": 2}


def test_a_finder_is_asked_for_what_it_knows(parts, draw) -> None:
    """The twin is found as the jaw; the stranger is nobody it could find."""
    stranger = replace(find_asset("hobby-corner-clamp").tracked_parts[2], name="stranger")
    poses = {"jaw": HERE, "twin": THERE, "stranger": Pose.from_translation(0, 0.1, 0.7)}
    finder = FakeFinder({"jaw": HERE})
    tracker = tracker_of([*parts, stranger], finder, delay_frames=1)
    frame = draw([*parts, stranger], poses)
    statuses = {each.part: each.status for _ in range(4) for each in tracker.track(frame).parts}
    assert {name for asked in finder.asked for name in asked} == {"jaw"}
    assert statuses["jaw"] is Status.TRACKED
    assert statuses["stranger"] is Status.SEARCHING


def test_the_thread_takes_one_frame_at_a_time(parts, draw) -> None:
    finder = FakeFinder({"jaw": HERE})
    lookout = LookoutThread(finder)
    frame = draw(parts[:1], {"jaw": HERE})
    assert lookout.take() is None
    assert lookout.offer(frame, ["jaw"])
    assert not lookout.offer(frame, ["jaw"])
    until_s = time.monotonic() + within(60)
    while (found := lookout.take()) is None:
        assert time.monotonic() < until_s
        time.sleep(0.01)
    lookout.close()
    assert found.frame == frame.name
    assert [each.part for each in found.hypotheses] == ["jaw"]
    assert not lookout.offer(frame, ["jaw"])


def test_a_part_that_is_hidden_at_once_is_not_dropped(parts, draw) -> None:
    """A hand comes while it is looked for: it starts, waits, and is tracked when it is seen."""

    class Refined(FakeFinder):
        def find(self, frame, wanted: Collection[str], *_) -> list[Hypothesis]:
            found = super().find(frame, wanted)
            return [replace(e, camera_from_body=HERE, is_refined=True) for e in found]

    tracker = SelfStartingTracker(
        create_tracker("gbot-without-graph", parts[:1], CAMERA),
        parts[:1],
        DelayedLookout(Refined({"jaw": HERE}), 6),
        catch_up=ImmediateCatchUp(Tracker(load_bodies(parts[:1]), CAMERA)),
    )
    u, v = CAMERA.color.project(HERE.translation[None])[0].astype(int)
    cover = (slice(v - 130, v + 130), slice(u - 130, u + 130), 0.4)
    clear = draw(parts[:1], {"jaw": HERE})
    hidden = draw(parts[:1], {"jaw": HERE}, cover=cover)
    for frame in [clear, clear, *[hidden] * 14]:
        said = tracker.track(frame).parts[0]
    assert tracker.account.started == 1
    assert said.status is Status.PREDICTED
    assert said.camera_from_body.distance_to(HERE) < 0.002
    said = [tracker.track(clear).parts[0] for _ in range(6)][-1]
    assert said.status is Status.TRACKED
    assert said.camera_from_body.distance_to(HERE) < 0.002
    assert tracker.account.dropped == 0
