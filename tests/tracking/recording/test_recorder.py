"""The recorder: it is never waited for, and a full disk costs nothing that was written."""

from __future__ import annotations

import logging
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest
import recordings

from snapfit.tracking.errors import RecordingError
from snapfit.tracking.recording import file as recording_file
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.recorder import Recorder, new_path
from snapfit.tracking.recording.records import result_fields

LIMIT_BYTES = 400_000


def test_frames_that_cannot_be_written_in_time_are_counted_and_nobody_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    gate = threading.Event()
    encode = recording_file.encode_color

    def slow(*arguments):
        assert gate.wait(400)
        return encode(*arguments)

    monkeypatch.setattr(recording_file, "encode_color", slow)
    recorder = recordings.begin(tmp_path / "bench.mcap")
    frame = recordings.frame(0)
    with caplog.at_level(logging.WARNING):
        for number in range(200):
            recorder.add(frame, [], result_fields(recordings.result(number)))
    n_dropped = recorder.account.dropped
    assert recorder.account.frames == 0
    assert 200 - 32 <= n_dropped <= 200 - 30
    assert caplog.text.count("there is no time to write all frames") == 1
    gate.set()
    recorder.close(limit_s=120)
    assert recorder.account.frames + recorder.account.dropped == 200
    with closing(OpenRecording(tmp_path / "bench.mcap")) as opened:
        # What was said is there, of frames without images too.
        assert [each.number for each in opened.results] == list(range(200))
        assert opened.n_unrecorded == n_dropped == recorder.account.dropped


def test_closing_is_quick_whatever_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    encode = recording_file.encode_color

    def slow(*arguments):
        while recorder._give_up_at_s == float("inf"):  # it is not closed yet
            time.sleep(0.005)
        time.sleep(0.2)
        return encode(*arguments)

    monkeypatch.setattr(recording_file, "encode_color", slow)
    recorder = recordings.begin(tmp_path / "bench.mcap")
    for number in range(20):
        recorder.add(recordings.frame(number), [], result_fields(recordings.result(number)))
    recorder.close(limit_s=0.3)
    assert recorder.account.dropped >= 18
    with closing(OpenRecording(tmp_path / "bench.mcap")) as opened:
        assert opened.problem is None
        assert len(opened.results) == 20


def record_until_full(folder: Path) -> None:
    """Runs in a process that may write so many bytes and no more."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT_BYTES, LIMIT_BYTES))
    recorder = recordings.begin(folder / "bench.mcap")
    for number in range(200):
        recorder.add(recordings.frame(number), [], result_fields(recordings.result(number)))
        while recorder.account.problem is None and recorder.account.frames <= number:
            time.sleep(0.001)
    recorder.close(limit_s=120)
    print(recorder.account.frames, recorder.account.problem)  # noqa: T201


def test_a_full_disk_stops_the_recording_and_nothing_else(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, __file__, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=400,
        check=True,
    )
    n_frames, _, problem = done.stdout.partition(" ")
    assert problem.strip() == f"stopped after {n_frames} frames: File too large"
    assert done.stderr.count("tracking goes on") == 1
    assert "Traceback" not in done.stderr
    path = tmp_path / "bench.mcap"
    assert path.stat().st_size <= LIMIT_BYTES
    with closing(OpenRecording(path)) as opened:
        assert opened.problem is not None
        assert "was not finished" in opened.problem
        assert len(opened.results) == int(n_frames) > 10
        for number, each in enumerate(opened.results):
            shown, wanted = opened.frame(each), recordings.frame(number)
            assert shown.color.tobytes() == wanted.color.tobytes()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(RecordingError, match="cannot be made"):
        new_path(tmp_path / "file" / "inside", "bench", 0)
    taken = tmp_path / "bench.mcap"
    taken.write_text("somebody else's")
    with pytest.raises(RecordingError, match="cannot be written"):
        recordings.begin(taken)
    assert taken.read_text() == "somebody else's"


def test_every_run_has_a_file_of_its_own(tmp_path: Path) -> None:
    first = new_path(tmp_path / "new", "bench", 0)
    assert first.name == "bench-19700101T000000Z.mcap"
    first.touch()
    assert new_path(tmp_path / "new", "bench", 0).name == "bench-19700101T000000Z-2.mcap"


def test_a_bug_in_recording_never_reaches_who_tracks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_arguments):
        raise RuntimeError("a bug")

    monkeypatch.setattr(recording_file, "encode_color", broken)
    recorder: Recorder = recordings.begin(tmp_path / "bench.mcap")
    recorder.add(recordings.frame(0), [], result_fields(recordings.result(0)))
    recorder.close(limit_s=120)
    recorder.add(recordings.frame(1), [], {})
    assert recorder.account.problem == "stopped after 0 frames: RuntimeError('a bug')"


if __name__ == "__main__":
    record_until_full(Path(sys.argv[1]))
