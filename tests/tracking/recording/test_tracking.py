"""What stands around a tracker: every call that changes what it does is written down, in order."""

from __future__ import annotations

import logging
from contextlib import closing
from pathlib import Path

import pytest
import recordings

from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.finding.account import LookAccount
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import Found
from snapfit.tracking.recording.comparison import Comparison
from snapfit.tracking.recording.events import EventLog
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.records import EventRecord, found_event, found_of, result_fields
from snapfit.tracking.recording.replay import Replayed
from snapfit.tracking.recording.tracking import (
    LogToRecording,
    RecordingControls,
    RecordingTracker,
)

FOUND = Found("000001", (Hypothesis("box", recordings.pose(3), 1 / 3, True),), 12.5, "a problem")


class FakeLookout:
    names, account = ("box",), LookAccount()

    def __init__(self) -> None:
        self.answers = [None, FOUND]

    def offer(self, frame, wanted) -> bool:
        del frame
        return wanted == ("box",)

    def take(self):
        return self.answers.pop(0) if self.answers else None

    def close(self) -> None:
        """Nothing runs."""


class FakeTracker:
    names = ("box",)

    def __init__(self, lookout) -> None:
        self.lookout = lookout

    def start(self, frame, poses) -> None:
        del frame
        if not poses:
            raise TrackingError("no pose")

    def track(self, frame):
        self.lookout.take()
        number = int(frame.name)
        if number == 2:
            raise FrameError(frame.name, "does not fit")
        return recordings.result(number)


class FakeControls:
    def set_state(self, state: str) -> None:
        assert state == "closed"

    def search(self, part: str) -> None:
        if part != "box":
            raise TrackingError(f"no part {part}")


def test_what_came_is_with_the_frame_before_which_it_came(tmp_path: Path) -> None:
    events = EventLog()
    recorder = recordings.begin(tmp_path / "bench.mcap")
    tracker = RecordingTracker(FakeTracker(events.lookout(FakeLookout())), events, recorder)
    with pytest.raises(TrackingError):
        tracker.start(recordings.frame(0), {})
    tracker.start(recordings.frame(0), {"box": recordings.pose(1)})
    tracker.track(recordings.frame(0))
    controls = RecordingControls(FakeControls(), events)
    controls.set_state("closed")
    controls.search("box")
    with pytest.raises(TrackingError):
        controls.search("lid")
    tracker.track(recordings.frame(1))
    with pytest.raises(FrameError):
        tracker.track(recordings.frame(2))
    assert tracker.names == ("box",)
    assert events.finds == ("box",)
    recorder.close(limit_s=120)
    with closing(OpenRecording(tmp_path / "bench.mcap")) as opened:
        records = [opened.record(each) for each in opened.results]
    kinds = [[event.kind for event in record.events] for record in records]
    assert kinds == [["start"], ["set_state", "stop", "found"], []]
    start = records[0].events[0].poses["box"]
    assert Pose(start).matrix.tobytes() == recordings.pose(1).matrix.tobytes()
    assert [event.name for event in records[1].events[:2]] == ["closed", "box"]
    assert records[2].error == "frame 000002: does not fit"
    assert (records[2].parts, records[2].has_images) == ([], True)


def test_a_finders_answer_comes_back_bit_for_bit() -> None:
    text = found_event(FOUND).model_dump_json()
    again = found_of(EventRecord.model_validate_json(text))
    assert (again.frame, again.duration_ms, again.problem) == ("000001", 12.5, "a problem")
    (hypothesis,) = again.hypotheses
    assert (hypothesis.part, hypothesis.score, hypothesis.is_refined) == ("box", 1 / 3, True)
    wanted = recordings.pose(3).matrix
    assert hypothesis.camera_from_body.matrix.tobytes() == wanted.tobytes()


def test_a_comparison_notices_every_kind_of_difference(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "bench.mcap", 4)
    with closing(OpenRecording(path)) as opened:
        records = [opened.record(each) for each in opened.results]
    frame = recordings.frame(0)
    comparison = Comparison()
    comparison.add(Replayed(records[0], frame, recordings.result(0)))
    assert comparison.is_identical
    comparison.add(Replayed(records[1], None, None, "not recorded"))
    assert (comparison.unrecorded, comparison.is_identical) == (1, True)
    comparison.add(Replayed(records[1], frame, recordings.result(2)))
    assert (comparison.different, comparison.first_different) == (1, "000001")
    moved_m = recordings.pose(1).distance_to(recordings.pose(2))
    assert comparison.largest_m == pytest.approx(moved_m)
    assert not comparison.is_identical
    broken = Comparison()
    broken.add(Replayed(records[2], frame, None, "a kernel is gone"))
    assert broken.problems == ["frame 000002: a kernel is gone"]
    assert not broken.is_identical


def test_the_log_goes_into_the_recording_and_a_bad_line_harms_nobody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging, "raiseExceptions", False)
    recorder = recordings.begin(tmp_path / "bench.mcap")
    logger = logging.Logger("snapfit.test")
    logger.addHandler(LogToRecording(recorder))
    logger.debug("not this one")
    logger.warning("frame %s is %d px too small", "000007", 3)
    logger.warning("%d", "no number")
    recorder.add(recordings.frame(0), [], result_fields(recordings.result(0)))
    recorder.close(limit_s=120)
    with closing(OpenRecording(tmp_path / "bench.mcap")) as opened:
        assert opened.log == ["frame 000007 is 3 px too small"]
