import json
import math
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh
import typer
from typer.testing import CliRunner

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.server.cli import track_run
from snapfit.server.cli.track import track
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CAMERA = RgbdCamera(
    color=PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5),
    depth=PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5),
)
N_FRAMES = 5

app = typer.Typer()
app.command()(track)
runner = CliRunner(env={"COLUMNS": "200"})


def true_pose(number: int) -> Pose:
    return Pose.from_translation(0.001 * number, 0, 0.5)


class ShiftedTracker:
    """Stands 3 mm beside the truth, says so for the box, and loses it in the last frame."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self.names = [part.name for part in parts]
        self.started_at: list[tuple[str, Mapping[str, Pose]]] = []

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        self.started_at.append((frame.name, camera_from_body))

    def track(self, frame: Frame) -> TrackingResult:
        number = int(frame.name)
        pose = Pose.from_translation(0.003, 0, 0) @ true_pose(number)
        estimate = PartEstimate("box", Status.TRACKED, 0.9, pose)
        if number == N_FRAMES - 1:
            estimate = PartEstimate("box", Status.LOST, 0.0, None)
        return TrackingResult(frame.name, frame.captured_at_ns, (estimate,), duration_ms=1.25)


@pytest.fixture
def trackers(monkeypatch: pytest.MonkeyPatch) -> list[ShiftedTracker]:
    """The trackers that the command has made, in the place of real ones."""
    made: list[ShiftedTracker] = []

    def create(
        method: str,
        parts: Sequence[Part],
        camera: RgbdCamera,
        progress: Any,
        *,
        asset: Asset | None,
        frame_rate_hz: float,
    ) -> ShiftedTracker:
        assert asset is None  # the recording has loose parts
        assert camera.color == CAMERA.color
        progress(f"preparing {method}", 1.0)
        assert frame_rate_hz > 0
        made.append(ShiftedTracker(parts))
        return made[-1]

    monkeypatch.setattr(track_run, "create_tracker", create)
    return made


@pytest.fixture
def sequence(tmp_path: Path) -> Path:
    take = tmp_path / "take"
    take.mkdir()
    trimesh.creation.box((0.04, 0.05, 0.06)).export(take / "box.ply")
    with SequenceWriter(take, CAMERA, bodies={"box": BodyRecord(mesh="box.ply")}) as writer:
        for i in range(N_FRAMES):
            color = np.full((48, 64, 3), 90, np.uint8)
            truth = GroundTruth(f"{i:03d}", {"box": true_pose(i)})
            writer.write(truth.frame, color, np.full((48, 64), 500, np.uint16), truth)
    return take


def row(output: str, name: str) -> list[str]:
    """The cells of the first table row that begins with a name."""
    rows = ([cell.strip() for cell in line.split("│")[1:-1]] for line in output.splitlines())
    return next(cells for cells in rows if cells and cells[0] == name)


def test_the_summary_counts_and_judges(sequence: Path, trackers: list[ShiftedTracker]) -> None:
    result = runner.invoke(app, [str(sequence)])
    assert result.exit_code == 0, result.output
    assert row(result.output, "box") == [
        *("box", "5", "4", "1", "0.90"),
        *("5", "3.00", "inf", "0.00", "inf", "3.00", "80.0 %"),
    ]
    assert "5 frames; 1.25 ms a frame (median) for 1 part" in result.output
    ((frame, poses),) = trackers[0].started_at
    assert frame == "000"
    np.testing.assert_allclose(poses["box"].matrix, true_pose(0).matrix)


def test_poses_are_written_a_line_a_frame_and_part(
    sequence: Path, trackers: list[ShiftedTracker], tmp_path: Path
) -> None:
    out = tmp_path / "poses.jsonl"
    result = runner.invoke(app, [str(sequence), "--out", str(out)])
    assert result.exit_code == 0, result.output
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    assert [line["frame"] for line in lines] == ["000", "001", "002", "003", "004"]
    assert list(lines[0]) == ["frame", "part", "status", "confidence", "camera_from_body", "ms"]
    assert lines[2] == {
        "frame": "002",
        "part": "box",
        "status": "tracked",
        "confidence": 0.9,
        "camera_from_body": [[1, 0, 0, 0.005], [0, 1, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]],
        "ms": 1.25,
    }
    assert (lines[4]["status"], lines[4]["camera_from_body"]) == ("lost", None)


def test_the_film_shows_every_frame(
    sequence: Path, trackers: list[ShiftedTracker], tmp_path: Path
) -> None:
    film = tmp_path / "film.mp4"
    result = runner.invoke(app, [str(sequence), "--video", str(film)])
    assert result.exit_code == 0, result.output
    capture = cv2.VideoCapture(str(film))
    pictures = []
    while (got := capture.read())[0]:
        pictures.append(got[1])
    capture.release()
    assert len(pictures) == N_FRAMES
    assert pictures[0].shape == (48, 64, 3)
    # The box is drawn into the grey image, and in the last frame, where it is lost, it is not.
    assert np.ptp(pictures[0].astype(int), axis=2).max() > 40
    assert np.ptp(pictures[-1].astype(int), axis=2).max() < 15


def test_bad_frames_are_skipped_told_and_counted(
    sequence: Path, trackers: list[ShiftedTracker]
) -> None:
    (sequence / "depth" / "002.png").unlink()
    color = sequence / "color" / "000.jpg"
    color.write_bytes(color.read_bytes()[:-90])
    result = runner.invoke(app, [str(sequence)])
    assert result.exit_code == 0, result.output
    assert "skipped frame 000" in result.output
    assert "is truncated after" in result.output
    assert "skipped frame 002" in result.output
    assert "3 frames, 2 bad skipped" in result.output
    assert row(result.output, "box")[1] == "3"
    assert [frame for frame, _ in trackers[0].started_at] == ["001"]


def test_without_truth_nothing_is_judged(sequence: Path, trackers: list[ShiftedTracker]) -> None:
    (sequence / "gt.jsonl").unlink()
    result = runner.invoke(app, [str(sequence)])
    assert result.exit_code == 0, result.output
    assert row(result.output, "box") == ["box", "5", "4", "1", "0.90"]


def edit(key: str, value: Any) -> Callable[[Path], None]:
    def change(sequence: Path) -> None:
        path = sequence / "sequence.json"
        content = json.loads(path.read_text())
        content[key] = value
        path.write_text(json.dumps(content))

    return change


def remove_images(sequence: Path) -> None:
    for path in (sequence / "color").iterdir():
        path.unlink()


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (edit("initial_poses", {}), "take: no part has an initial pose to start from: add them"),
        (edit("fps", -1), "sequence.json: fps: input should be greater than 0, this is -1"),
        (edit("initial_poses", {"box": [[math.nan] * 4] * 4}), "initial_poses.box: a pose must be"),
        (remove_images, "take: none of its frames can be used"),
        (lambda sequence: (sequence / "sequence.json").unlink(), "neither sequence.json"),
        (lambda sequence: (sequence / "box.ply").unlink(), "box.ply: there is no such mesh file"),
    ],
)
def test_what_cannot_be_tracked_is_one_line_and_exit_code_2(
    sequence: Path, trackers: list[ShiftedTracker], damage: Any, problem: str
) -> None:
    damage(sequence)
    result = runner.invoke(app, [str(sequence)])
    assert result.exit_code == 2
    assert problem in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("error: ")


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--asset", "no-such"], "no-such: no such folder and no bundled asset"),
        (["--detector", "geometric"], "a detector needs an asset: name it with --asset"),
        (["--out", "nowhere/poses.jsonl"], "nowhere/poses.jsonl: cannot be written: No such file"),
        (["--video", "film.avi"], "film.avi: films are MP4: call it film.mp4"),
        (["--video", "nowhere/film.mp4"], "nowhere/film.mp4: there is no folder"),
    ],
)
def test_a_wrong_option_is_told_before_anything_is_tracked(
    sequence: Path, trackers: list[ShiftedTracker], options: list[str], problem: str
) -> None:
    result = runner.invoke(app, [str(sequence), *options])
    assert result.exit_code == 2
    assert problem in result.stderr
    assert trackers == []


def test_an_unknown_method_lists_those_there_are(sequence: Path) -> None:
    result = runner.invoke(app, [str(sequence), "--method", "magic"])
    assert result.exit_code == 2
    assert "there is no method 'magic'" in result.stderr
    assert "icg" in result.stderr


def test_asking_for_help_loads_no_tracker() -> None:

    code = (
        "import sys, typer; from snapfit.server.cli.track import track;"
        "from snapfit.server.cli.asset import asset_app;"
        "heavy = {'numba', 'cv2', 'scipy', 'trimesh', 'open3d'} & set(sys.modules);"
        "sys.exit(f'loads {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_real_tracker_follows_real_frames(real_frames: Path, tmp_path: Path) -> None:
    out = tmp_path / "poses.jsonl"
    result = runner.invoke(app, [str(real_frames), "--out", str(out)])
    assert result.exit_code == 0, result.output
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    assert [(line["frame"], line["part"]) for line in lines] == [
        ("000200", "triangle"),
        ("000200", "schauma"),
        ("000201", "triangle"),
        ("000201", "schauma"),
    ]
    bottle = Pose.from_matrix(lines[3]["camera_from_body"])
    assert bottle.translation == pytest.approx((-0.004, 0.010, 0.436), abs=0.02)
