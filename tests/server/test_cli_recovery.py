"""`snapfit benchmark --recovery`: from sequences to the page, and clear errors."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import typer
from typer.testing import CliRunner

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.server.cli.benchmark import benchmark
from snapfit.tracking.benchmark import recovery
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CAMERA = RgbdCamera(*[PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)] * 2)
TRUTH = Pose.from_translation(0, 0, 0.5)

app = typer.Typer()
app.command()(benchmark)
runner = CliRunner(env={"COLUMNS": "200"})


class FaithfulTracker:
    """Says the truth wherever it sees the bench."""

    names = ("box",)

    def start(self, _frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        assert list(camera_from_body) == ["box"]

    def track(self, frame: Frame) -> TrackingResult:
        is_seen = frame.depth is not None and (frame.depth == 500).all()
        pose, status = (TRUTH, Status.TRACKED) if is_seen else (None, Status.LOST)
        estimate = PartEstimate("box", status, 0.9, pose)
        return TrackingResult(frame.name, frame.captured_at_ns, (estimate,), duration_ms=1.25)


@pytest.fixture(autouse=True)
def _made(monkeypatch: pytest.MonkeyPatch) -> None:
    def create(method: str, *_: Any, **__: Any) -> FaithfulTracker:
        if method == "yolov8pose":
            raise TrackingError("detector.json: is missing")
        return FaithfulTracker()

    monkeypatch.setattr(recovery, "create_tracker", create)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    for condition in ("normal", "blur"):
        take = folder / "clamp" / "test" / condition
        take.mkdir(parents=True)
        trimesh.creation.box((0.04, 0.05, 0.06)).export(take / "box.ply")
        bodies = {"box": BodyRecord(mesh="box.ply")}
        with SequenceWriter(take, CAMERA, bodies=bodies, frame_rate_hz=1.0) as writer:
            for i in range(9):
                color = np.full((48, 64, 3), 90, np.uint8)
                truth = GroundTruth(f"{i:03d}", {"box": TRUTH})
                writer.write(truth.frame, color, np.full((48, 64), 500, np.uint16), truth)
    return folder


def run(out: Path, *more: str) -> Any:
    return runner.invoke(app, ["--out", str(out), "--recovery", *more])


def test_the_page_the_record_and_a_line_for_people(data: Path, tmp_path: Path) -> None:
    page = tmp_path / "recovery.md"
    page.write_text("# Mine\n\n<!-- benchmark -->\nstale figures\n<!-- /benchmark -->\n\nAfter.\n")
    out = tmp_path / "out"
    methods = "gbot+reinit,gbot"
    result = run(out, "--data", str(data), "--methods", methods, "--report", str(page))
    assert result.exit_code == 0, result.output
    assert "cold start, gbot+reinit: 0 frames (median), 0 (p90), 0.0 % never of 2" in result.output
    text = page.read_text()
    assert text.startswith("# Mine\n")
    assert text.endswith("After.\n")
    assert "stale figures" not in text
    assert "| gbot | clamp | 2 | 0 | 0 | 100.0 | 0.0 | - |" in text
    assert "| gbot+reinit | normal | 1 | 0 |" in text
    record = json.loads((out / "recovery.json").read_text())
    # A cold start is tried of what finds parts, a covered camera of both.
    assert [(each["kind"], each["method"]) for each in record["trials"]].count(
        ("covered camera", "gbot")
    ) == 2
    assert {each["method"] for each in record["trials"] if each["kind"] == "cold start"} == {
        "gbot+reinit"
    }


def test_what_cannot_be_run_is_told_once_and_the_rest_is_written(
    data: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    result = run(out, "--data", str(data), "--methods", "yolov8pose,gbot")
    assert result.exit_code == 2
    assert result.stderr.count("clamp: yolov8pose: detector.json: is missing") == 1
    text = (out / "recovery.md").read_text()
    assert "Not run: clamp: yolov8pose" in text
    assert "| gbot | clamp | 2 |" in text


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        ([], "--recovery needs --data"),
        (["--data", "x", "--quick"], "--quick does not go with --recovery"),
        (["--data", "x", "--films"], "--films does not go with --recovery"),
        (["--mistakes", "x"], "--recovery does not go with --mistakes"),
        (["--data", "x", "--methods", "gbot+reinit-cold"], "tries gbot+reinit from a cold start"),
    ],
)
def test_what_does_not_go_together_is_refused(
    tmp_path: Path, more: list[str], problem: str
) -> None:
    result = run(tmp_path / "out", *more)
    assert result.exit_code == 2
    assert problem in result.stderr
