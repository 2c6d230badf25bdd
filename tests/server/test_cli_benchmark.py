import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh
import typer
from typer.testing import CliRunner

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.server.cli import benchmark_run
from snapfit.server.cli.benchmark import benchmark
from snapfit.tracking.benchmark import benchmark as benchmark_module
from snapfit.tracking.benchmark import contest, quick
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CAMERA = RgbdCamera(*[PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)] * 2)
TRUTH = Pose.from_translation(0, 0, 0.5)
N_FRAMES = 4

app = typer.Typer()
app.command()(benchmark)
runner = CliRunner(env={"COLUMNS": "200"})


class FaithfulTracker:
    """Says the truth, 1 mm aside."""

    def __init__(self, *_: Any) -> None:
        pass

    def start(self, _frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        assert list(camera_from_body) == ["box"]

    def track(self, frame: Frame) -> TrackingResult:
        pose = Pose.from_translation(0.001, 0, 0) @ TRUTH
        estimate = PartEstimate("box", Status.TRACKED, 0.9, pose)
        return TrackingResult(frame.name, frame.captured_at_ns, (estimate,), duration_ms=1.25)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The methods for which trackers were made, in the place of real ones."""
    methods: list[str] = []

    def create(method: str, parts: Sequence[Part], *_: Any, **__: Any) -> FaithfulTracker:
        methods.append(method)
        return FaithfulTracker()

    monkeypatch.setattr(contest, "create_tracker", create)
    return methods


@pytest.fixture
def data(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    for condition in ("normal", "blur"):
        take = folder / "clamp" / "test" / condition
        take.mkdir(parents=True)
        trimesh.creation.box((0.04, 0.05, 0.06)).export(take / "box.ply")
        bodies = {"box": BodyRecord(mesh="box.ply")}
        with SequenceWriter(take, CAMERA, bodies=bodies, note="bench, seed 3") as writer:
            for i in range(N_FRAMES):
                color = np.full((48, 64, 3), 90, np.uint8)
                truth = GroundTruth(f"{i:03d}", {"box": TRUTH})
                writer.write(truth.frame, color, np.full((48, 64), 500, np.uint16), truth)
    return folder


def invoke(data: Path, out: Path, *more: str) -> Any:
    return runner.invoke(app, ["--data", str(data), "--out", str(out), *more])


def test_everything_is_written(data: Path, made: list[str], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "out"
    result = invoke(data, out)
    assert result.exit_code == 0, result.output
    assert made == ["icg", "icg"]
    text = (out / "benchmark.md").read_text()
    assert "| normal | icg | 99.0 | 100.0 | 0.10 | 0.0 | " in text
    assert "| overall | icg | 99.0 |" in text
    assert "bench, seed 3" in text
    assert "Frames: 8" in text
    content = json.loads((out / "benchmark.json").read_text())
    assert [row["condition"] for row in content["rows"]] == ["normal", "blur"]
    assert content["provenance"]["command"].split()[0] == "snapfit"
    assert cv2.imread(str(out / "clamp.png")) is not None
    assert cv2.imread(str(out / "reliability.png")) is not None
    assert "| clamp | blur | icg | box | 99.0 |" in (out / "parts.md").read_text()
    assert "99.0" in result.output
    for condition in ("normal", "blur"):
        film = cv2.VideoCapture(str(out / "films" / f"clamp-{condition}.mp4"))
        assert film.get(cv2.CAP_PROP_FRAME_COUNT) == N_FRAMES
        assert film.get(cv2.CAP_PROP_FRAME_WIDTH) == 2 * 64
        film.release()


def test_a_second_call_runs_nothing_and_leaves_films_alone(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    invoke(data, out, "--condition", "blur")
    film = out / "films" / "clamp-blur.mp4"
    written = film.stat().st_mtime_ns
    result = invoke(data, out)
    assert made == ["icg", "icg"]
    assert "finished before: clamp-blur: icg" in result.output
    assert film.stat().st_mtime_ns == written
    assert (out / "films" / "clamp-normal.mp4").is_file()


def test_quick_takes_the_first_frames_and_makes_no_films(
    data: Path, made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark_run, "QUICK_FRAMES", 2)
    out = tmp_path / "out"
    result = invoke(data, out, "--quick")
    assert result.exit_code == 0, result.output
    text = (out / "benchmark.md").read_text()
    assert "Frames: 4 in 2 sequences, the first 2 of each: a quick look, no result" in text
    assert not (out / "films").exists()


def test_without_matplotlib_all_but_the_plots_is_made(
    data: Path, made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    out = tmp_path / "out"
    result = invoke(data, out, "--no-films")
    assert result.exit_code == 0, result.output
    assert "pip install 'snapfit[benchmark]'" in result.output
    names = sorted(path.name for path in out.iterdir())
    assert names == ["benchmark.json", "benchmark.md", "parts.md", "runs"]


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--methods", "icg,magic"], "there is no method 'magic'; the methods are "),
        (["--methods", ","], "no method to benchmark"),
        (["--asset", "lamp"], "has no asset 'lamp'; it has: clamp"),
        (["--condition", "night"], "has no condition 'night'; it has: blur, normal"),
    ],
)
def test_a_wrong_option_is_one_line_before_anything_is_run(
    data: Path, made: list[str], tmp_path: Path, options: list[str], problem: str
) -> None:
    result = invoke(data, tmp_path / "out", *options)
    assert result.exit_code == 2
    assert problem in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert made == []
    assert not (tmp_path / "out").exists()


def test_an_incomplete_sequence_is_left_out_and_the_others_go_on(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    (data / "clamp" / "test" / "blur" / "depth" / "002.png").unlink()
    problem = "blur/depth/002.png: no such file: frame 002 is incomplete"
    result = invoke(data, tmp_path / "out")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: 1 runs are missing: clamp-blur: ")
    assert problem in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert "left out: clamp-blur" in result.stdout
    assert made == ["icg"]
    text = (tmp_path / "out" / "benchmark.md").read_text()
    assert "| normal | icg | 99.0 |" in text
    assert "**1 runs are missing here" in text
    assert problem in text


def test_an_unreadable_picture_is_told_at_the_end(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    (data / "clamp" / "test" / "normal" / "color" / "001.jpg").write_bytes(b"\xff\xd8 no more")
    result = invoke(data, tmp_path / "out", "--no-films")
    assert result.exit_code == 2
    assert "normal/color/001.jpg: is truncated" in result.stderr
    assert "a benchmark needs every frame" in result.stderr
    text = (tmp_path / "out" / "benchmark.md").read_text()
    assert "| blur | icg | 99.0 |" in text
    assert "frame 001" in text


def test_with_no_sequence_left_nothing_is_written(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    for condition in ("normal", "blur"):
        (data / "clamp" / "test" / condition / "gt.jsonl").unlink()
    result = invoke(data, tmp_path / "out")
    assert result.exit_code == 2
    assert "nothing could be run: " in result.stderr
    assert "4 frames, but ground truth of 0" in result.stderr
    assert made == []
    assert not list((tmp_path / "out").glob("benchmark.*"))


def test_an_unknown_asset_is_told_with_those_there_are(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    path = data / "clamp" / "test" / "blur" / "sequence.json"
    content = json.loads(path.read_text())
    del content["bodies"]
    path.write_text(json.dumps(content | {"asset": "time-machine"}))
    result = invoke(data, tmp_path / "out", "--no-films")
    assert result.exit_code == 2
    assert "blur/sequence.json: " in result.stderr
    assert "no bundled asset; bundled: geared-caliper, " in result.stderr
    assert "(this names 'time-machine')" in result.stderr
    assert made == ["icg"]


def test_a_folder_that_cannot_be_written_is_one_line_before_anything_is_run(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    result = invoke(data, tmp_path / "file" / "out")
    assert result.exit_code == 2
    assert "file/out: results cannot be written there: Not a directory" in result.stderr
    assert "choose another --out" in result.stderr
    assert made == []


def test_without_data_only_a_quick_benchmark_can_be_run(made: list[str], tmp_path: Path) -> None:
    result = runner.invoke(app, ["--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "--data is missing" in result.stderr
    assert made == []


def test_runs_of_other_code_are_taken_up_if_that_is_wanted(
    data: Path, made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    invoke(data, out, "--no-films")
    monkeypatch.setattr(benchmark_module, "code_version", lambda _: "another version")
    result = invoke(data, out, "--no-films", "--any-commit")
    assert result.exit_code == 0, result.output
    assert "finished before: clamp-blur: icg" in result.output
    assert made == ["icg", "icg"]
    invoke(data, out, "--no-films")
    assert made == ["icg"] * 4


def test_the_report_is_put_into_a_page_that_has_words_of_its_own(
    data: Path, made: list[str], tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    options = ("--no-films", "--report", str(page))
    invoke(data, tmp_path / "out", *options)
    assert page.read_text() == (tmp_path / "out" / "benchmark.md").read_text()
    page.write_text(
        "# Ours\n\nBefore.\n\n<!-- benchmark -->\nOutdated.\n<!-- /benchmark -->\n\nAfter.\n"
    )
    result = invoke(data, tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    text = page.read_text()
    assert text.startswith("# Ours\n\nBefore.\n\n<!-- benchmark -->\n\n- Command: `snapfit")
    assert text.endswith("by status, %.\n\n<!-- /benchmark -->\n\nAfter.\n")
    assert "Outdated" not in text
    invoke(data, tmp_path / "out", *options)
    assert page.read_text() == text
    missing = invoke(
        data, tmp_path / "out", "--no-films", "--report", str(tmp_path / "no" / "p.md")
    )
    assert missing.exit_code == 2
    assert "p.md: cannot be written" in missing.stderr


@pytest.mark.slow
def test_quick_renders_its_own_dataset_for_the_real_tracker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(quick, "QUICK_FRAMES", 20)
    result = runner.invoke(app, ["--out", str(tmp_path), "--quick"])
    assert result.exit_code == 0, result.output
    normal, hand = json.loads((tmp_path / "benchmark.json").read_text())["rows"]
    assert (normal["asset"], normal["condition"]) == ("hobby-corner-clamp", "normal")
    assert (hand["condition"], hand["n_frames"]) == ("hand", 20)
    assert set(normal["parts"]) == {"base", "jaw", "bolt"}
    assert normal["score"]["add_recall"] > 95
    assert normal["score"]["lost"] == 0
    assert 0 < normal["score"]["time_ms"] < 1000


def test_asking_for_help_loads_no_tracker() -> None:
    code = (
        "import sys; from snapfit.server.cli.benchmark import benchmark;"
        "heavy = {'numba', 'cv2', 'scipy', 'trimesh', 'matplotlib'} & set(sys.modules);"
        "sys.exit(f'loads {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
