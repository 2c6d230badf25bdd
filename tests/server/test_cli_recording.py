"""The commands that record and export, and a server that records."""

from __future__ import annotations

import importlib
import json
import sys
import types
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("onnx", reason="onnx is not installed: snapfit[test]")

from found_scene import FOUND, POSES, write_bundle, write_recording
from harness import Server, wait_for
from patience import within
from typer.testing import CliRunner

from snapfit.server.cli.main import app
from snapfit.tracking.errors import RecordingError
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.rerun_export import write_rerun
from snapfit.tracking.sources import open_source

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))


def snapfit(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, [str(each) for each in arguments])
    return done.exit_code, done.output


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("sequence") / "bench", POSES)


@pytest.fixture(scope="module")
def recorded(sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded") / "bench.mcap"
    code, told = snapfit("record", sequence, "--out", path)
    assert code == 0, told
    assert "2 frames, 0 dropped" in told
    return path


def test_frames_that_are_recorded_are_those_of_the_source(sequence: Path, recorded: Path) -> None:
    with closing(open_source(sequence)) as wanted, closing(open_source(recorded)) as source:
        assert source.camera.color == wanted.camera.color
        assert source.camera.depth == wanted.camera.depth
        assert source.asset is not None
        assert source.asset.name == "hobby-corner-clamp"
        assert source.frame_rate_hz == 10.0
        assert set(source.initial_poses) == set(FOUND)
        while (frame := wanted.read()) is not None:
            again = source.read()
            assert again is not None
            assert again.color.tobytes() == frame.color.tobytes()
            assert again.depth is not None
            assert frame.depth is not None
            assert again.depth.tobytes() == frame.depth.tobytes()
        assert source.read() is None


def test_frames_alone_are_tracked_and_not_replayed(recorded: Path, tmp_path: Path) -> None:
    out = tmp_path / "poses.jsonl"
    code, told = snapfit("track", recorded, "--out", out)
    assert code == 0, told
    statuses = {
        each["part"]: each["status"] for each in map(json.loads, out.read_text().splitlines())
    }
    assert {statuses[name] for name in FOUND} == {"tracked"}
    code, told = snapfit("replay", recorded)
    assert code == 2
    assert "nothing was tracked: use snapfit track" in told


def test_what_cannot_be_recorded_is_one_clear_line(sequence: Path, recorded: Path) -> None:
    code, told = snapfit("record", sequence, "--out", recorded)
    assert (code, told.count("\n")) == (2, 1)
    assert "cannot be written: File exists" in told


def test_without_the_viewer_it_says_what_to_install(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    code, told = snapfit("export", recorded, "--rerun", tmp_path / "out.rrd")
    assert (code, told.count("\n")) == (2, 1)
    assert "pip install 'snapfit[rerun]'" in told


class FakeRerun(types.ModuleType):
    """Notes what is logged, by the names of the viewer's interface."""

    def __init__(self) -> None:
        super().__init__("rerun")
        self.logged: list[tuple[str, str, dict[str, object]]] = []
        self.times: list[object] = []
        self.saved: list[str] = []
        self.ViewCoordinates = types.SimpleNamespace(RDF=("ViewCoordinates", {}))

    def __getattr__(self, name: str):
        if name.startswith("_"):
            raise AttributeError(name)
        return lambda *arguments, **given: (name, {**dict(enumerate(arguments)), **given})

    def RecordingStream(self, name: str, *, recording_id: str) -> FakeRerun:
        assert (name, recording_id) == ("snapfit", "bench")
        return self

    def save(self, path: str) -> None:
        self.saved.append(path)

    def log(self, entity: str, what: tuple[str, dict[str, object]], static: bool = False) -> None:  # noqa: ARG002
        self.logged.append((entity, *what))

    def set_time(self, timeline: str, *, timestamp: object) -> None:
        assert timeline == "time"
        self.times.append(timestamp)

    def disconnect(self) -> None:
        """Done."""


def test_the_viewer_gets_images_cameras_and_parts(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = FakeRerun()
    monkeypatch.setitem(sys.modules, "rerun", fake)
    assert importlib.import_module("rerun") is fake
    with closing(OpenRecording(recorded)) as opened:
        assert write_rerun(opened, tmp_path / "out.rrd") == 2
        with pytest.raises(RecordingError, match="there is no folder"):
            write_rerun(opened, tmp_path / "nowhere" / "out.rrd")
        stamps = [each.captured_at_ns for each in opened.results]
    assert fake.saved == [str(tmp_path / "out.rrd")]
    assert [np.datetime64(time).astype(int) for time in fake.times] == stamps
    kinds = [(entity, kind) for entity, kind, _ in fake.logged]
    assert kinds.count(("camera/color", "EncodedImage")) == 2
    assert kinds.count(("camera/depth", "EncodedDepthImage")) == 2
    assert {("camera/color", "Pinhole"), ("camera/parts/base", "Mesh3D")} <= set(kinds)
    image = next(given for _, kind, given in fake.logged if kind == "EncodedImage")
    assert bytes(image["contents"]).startswith(b"\x89PNG")  # type: ignore[arg-type]


def test_a_server_records_and_tells_of_it(tmp_path: Path) -> None:
    write_recording(tmp_path / "recording")
    bundle = write_bundle(tmp_path / "hobby-corner-clamp")
    text = f'[station]\nsource = "recording"\nasset = "{bundle}"\nmethod = "icg"\n'
    (tmp_path / "snapfit.toml").write_text(text)
    folder = tmp_path / "recordings"
    command = [SNAPFIT, "serve", "--config", str(tmp_path / "snapfit.toml")]
    server = Server(command=[*command, "--record", str(folder), "--port"])
    try:
        wait_for(server.answers)
        health = wait_for(
            lambda: (it := server.worker()["recording"]) and it["frames"] > 20 and it, 120
        )
        assert health["problem"] is None
        assert health["megabytes"] > 0
    finally:
        code, _, err = server.end()
    assert code == 0
    (path,) = folder.glob("bench-1-*.mcap")
    assert health["file"] == str(path)
    with closing(OpenRecording(path)) as opened:
        assert opened.problem is None
        assert opened.station.method == "icg"
        assert len(opened.results) > 20
        n_unrecorded = opened.n_unrecorded
    if n_unrecorded:  # its thread was held up for seconds, and says so
        assert err.count("\n") == err.count("there is no time to write all frames") == 1
        return
    assert (health["dropped"], err) == (0, "")
    code, told = snapfit("replay", path)
    assert code == 0, told
    assert "all the same, bit for bit" in told


def test_a_server_that_cannot_record_ends_with_the_folder(tmp_path: Path) -> None:
    write_recording(tmp_path / "recording", POSES)
    (tmp_path / "file").write_text("no folder")
    text = '[station]\nsource = "recording"\ndetector = "none"\nrecord = "file/inside"\n'
    (tmp_path / "snapfit.toml").write_text(text)
    server = Server(
        command=[SNAPFIT, "serve", "--config", str(tmp_path / "snapfit.toml"), "--port"]
    )
    try:
        server.process.wait(within(120))
    finally:
        code, _, err = server.end()
    assert code == 2
    assert f"{tmp_path / 'file' / 'inside'}: cannot be made" in err
