"""A station that is recorded, killed, replayed: nothing that was written is lost, and the poses are
the same, bit for bit."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from patience import within

pytest.importorskip("onnx", reason="onnx is not installed: snapfit[test]")

import recorded_station
from found_scene import write_bundle
from recorded_station import opened, play, write_moving
from typer.testing import CliRunner

from snapfit.server.cli.main import app
from snapfit.tracking.recording.comparison import Comparison
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.records import ResultRecord
from snapfit.tracking.recording.replay import Replay
from snapfit.tracking.recording.tracking import RecordingControls, RecordingTracker
from snapfit.tracking.tracker import Tracker

FRAMES_BEFORE_THE_KILL = 60


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A moving scene and the bundle whose network finds its parts."""
    folder = tmp_path_factory.mktemp("scene")
    return write_moving(folder / "bench"), write_bundle(folder / "hobby-corner-clamp")


@pytest.fixture(scope="module")
def killed(scene: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a process had recorded when it was killed."""
    folder = tmp_path_factory.mktemp("killed")
    command = [sys.executable, recorded_station.__file__, *map(str, scene), str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if min(map(int, line.split())) >= FRAMES_BEFORE_THE_KILL:
                process.kill()
                break
        assert process.wait(within(60)) == -signal.SIGKILL
    (path,) = folder.glob("*.mcap")
    return path


@pytest.fixture
def recording(killed: Path) -> Iterator[OpenRecording]:
    with closing(OpenRecording(killed)) as it:
        yield it


def test_what_was_written_before_a_kill_is_there(recording: OpenRecording) -> None:
    assert recording.problem is not None
    assert "was not finished" in recording.problem
    assert len(recording.results) >= FRAMES_BEFORE_THE_KILL
    numbers = [each.number for each in recording.results]
    assert numbers == list(range(len(numbers)))
    assert recording.n_unrecorded == 0
    records = [recording.record(each) for each in recording.results]
    kinds = {event.kind for each in records for event in each.events}
    assert {"found", "caught_up"} <= kinds
    n_poses = sum(p.camera_from_body is not None for r in records for p in r.parts)
    assert n_poses > FRAMES_BEFORE_THE_KILL / 2


def test_a_replay_gives_the_same_poses_bit_for_bit(recording: OpenRecording) -> None:
    comparison = Comparison()
    for each in Replay(recording).run():
        comparison.add(each)
    assert comparison.is_identical
    assert comparison.frames == len(recording.results)
    assert comparison.poses > FRAMES_BEFORE_THE_KILL / 2


def records_of(recording: OpenRecording, monkeypatch: pytest.MonkeyPatch) -> list[ResultRecord]:
    """The records, to be changed for the replay."""
    records = [recording.record(each) for each in recording.results]
    monkeypatch.setattr(recording, "record", lambda result: records[result.number])
    return records


def test_without_the_finders_answers_it_would_be_another(
    recording: OpenRecording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So the comparison can fail, and the answers are needed."""
    for record in records_of(recording, monkeypatch):
        record.events.clear()
    comparison = Comparison()
    for each in Replay(recording).run():
        comparison.add(each)
    assert not comparison.is_identical
    assert comparison.different > 0


def test_a_start_that_comes_a_frame_late_is_noticed(
    recording: OpenRecording, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The frame in which it came counts."""
    records = records_of(recording, monkeypatch)
    first = next(
        record
        for record in records
        if any(event.kind == "caught_up" and event.poses for event in record.events)
    )
    after = records[first.number + 1]
    after.events[:0] = first.events
    first.events.clear()
    comparison = Comparison()
    for each in Replay(recording).run():
        comparison.add(each)
    assert not comparison.is_identical


def test_the_command_says_so(killed: Path, tmp_path: Path) -> None:
    out = tmp_path / "poses.jsonl"
    done = CliRunner().invoke(app, ["replay", str(killed), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "was not finished" in done.output
    assert "all the same, bit for bit" in done.output
    assert out.read_text().count("\n") >= 3 * FRAMES_BEFORE_THE_KILL


class OperatorOf:
    """What an operator does to the tracker proper."""

    def __init__(self, tracker: Tracker) -> None:
        self.set_state, self.search = tracker.set_state, tracker.stop


def test_what_an_operator_did_is_done_again(scene: tuple[Path, Path], tmp_path: Path) -> None:
    source, bundle = scene
    pipeline = opened(source, bundle, tmp_path)
    recorded = pipeline.tracker
    assert isinstance(recorded, RecordingTracker)
    proper = recorded._tracker._tracker  # type: ignore[attr-defined]
    controls = RecordingControls(OperatorOf(proper), recorded._events)
    for _ in range(200):
        if play(pipeline, 1, pause_s=0.05) == 2:
            break
    controls.search("base")
    last = pipeline.source.asset.states[-1].name  # type: ignore[union-attr]
    controls.set_state(last)
    play(pipeline, 20, pause_s=0.05)
    pipeline.close()
    (path,) = tmp_path.glob("*.mcap")
    comparison = Comparison()
    with closing(OpenRecording(path)) as recording:
        records = [recording.record(each) for each in recording.results]
        for each in Replay(recording).run():
            comparison.add(each)
    kinds = [event.kind for record in records for event in record.events]
    assert {"stop", "set_state"} <= set(kinds)
    assert last in {record.state for record in records}
    assert comparison.is_identical, comparison
    assert comparison.poses > 10


def test_a_method_without_a_detector_beside_replays_the_same(
    scene: tuple[Path, Path], tmp_path: Path
) -> None:
    source, bundle = scene
    pipeline = opened(source, bundle, tmp_path, method="yolov8pose", detector="none")
    play(pipeline, 5)
    pipeline.close()
    (path,) = tmp_path.glob("*.mcap")
    done = CliRunner().invoke(app, ["replay", str(path)])
    assert done.exit_code == 0, done.output
    assert "all the same, bit for bit" in done.output


@pytest.mark.slow
def test_jpeg_says_what_it_gives_up(scene: tuple[Path, Path], tmp_path: Path) -> None:
    source, bundle = scene
    for color in ("png", "jpeg"):
        pipeline = opened(source, bundle, tmp_path / color, record_color=color)
        play(pipeline, 25, pause_s=0.05)
        pipeline.close()
    sizes = {path.parent.name: path.stat().st_size for path in tmp_path.glob("*/*.mcap")}
    assert sizes["jpeg"] < 0.7 * sizes["png"]
    (path,) = tmp_path.glob("jpeg/*.mcap")
    done = CliRunner().invoke(app, ["replay", str(path)])
    assert done.exit_code == 0, done.output
    assert "colour was recorded as JPEG" in done.output
