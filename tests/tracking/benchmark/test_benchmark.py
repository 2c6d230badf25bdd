import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.tracking.benchmark import benchmark as benchmark_module
from snapfit.tracking.benchmark.benchmark import Outcome, Task, check_methods, run_tasks
from snapfit.tracking.benchmark.sequences import find_sequences
from snapfit.tracking.benchmark.store import RunStore
from snapfit.tracking.errors import FrameError, SourceError, TrackingError


@pytest.fixture
def tasks(dataset: Path) -> list[Task]:
    return [Task(folder, "icg") for folder in find_sequences(dataset, ["clamp"])]


def test_each_frame_is_judged_from_the_true_start(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    (outcome,) = run_tasks(tasks[:1], tmp_path / "runs")
    run = outcome.run
    assert (run.asset, run.condition, run.method) == ("clamp", "normal", "icg")
    assert run.parts == ("box", "pin")
    assert run.symmetric.tolist() == [False, True]
    assert trackers[0].started["pin"].translation == pytest.approx((0, 0.05, 0.5))
    translation_m = run.error("translation_m")
    assert translation_m[:5] == pytest.approx(0.002)
    assert translation_m[5].tolist() == [math.inf, pytest.approx(0.002)]
    assert run.error("mssd_m")[0] == pytest.approx(0.002)
    assert run.error("mspd_px")[0, 0] == pytest.approx(60 * 0.002 / 0.47, rel=1e-3)
    assert run.error("add_m")[0, 0] == pytest.approx(0.002)
    assert run.error("add_m")[0, 1] <= 0.002
    assert run.has_estimate.tolist() == [[True, True]] * 5 + [[False, True]]
    assert run.visibility[0, 0] == 1.0
    assert math.isnan(run.visibility[0, 1])
    assert run.true_states.tolist() == ["apart"] * 3 + ["joined"] * 3
    assert run.states.tolist() == ["apart"] * 4 + ["joined"] * 2


def test_a_part_that_turns_about_its_axis_has_not_moved(
    scripted: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(lambda number, _, truth: truth @ Pose.exp([0, 0, 0.4 * number, 0, 0, 0]))
    (outcome,) = run_tasks(tasks[:1], tmp_path / "runs")
    assert outcome.run.error("rotation_rad")[5] == pytest.approx([2.0, 0.0], abs=1e-6)
    # The axis is cut into 315 angles.
    assert outcome.run.error("mssd_m")[5, 1] <= 0.01 * math.pi / 315 + 1e-9


def test_what_is_finished_is_not_run_again(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    first = list(run_tasks(tasks, tmp_path / "runs"))
    assert len(trackers) == len(tasks) == 3
    again = list(run_tasks(tasks, tmp_path / "runs"))
    assert len(trackers) == 3
    assert [each.is_new for each in first + again] == [True] * 3 + [False] * 3
    for old, new in zip(first, again, strict=True):
        assert new.circumstances == old.circumstances
        assert new.run.parts == old.run.parts
        np.testing.assert_array_equal(new.run.errors, old.run.errors)
        np.testing.assert_array_equal(new.run.camera_from_body, old.run.camera_from_body)
        assert new.run.states.tolist() == old.run.states.tolist()


def change_truth(task: Task) -> None:
    path = task.folder.directory / "gt.jsonl"
    path.write_text(path.read_text().replace("0.5", "0.51"))


def change_image(task: Task) -> None:
    path = task.folder.directory / "color" / "001.jpg"
    path.write_bytes(path.read_bytes() + b"\xff\xd9")


def change_mesh(task: Task) -> None:
    path = task.folder.directory / "box.ply"
    path.write_bytes((task.folder.directory / "pin.ply").read_bytes())


@pytest.mark.parametrize("change", [change_truth, change_image, change_mesh])
def test_other_data_is_run_anew(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path, change: Callable
) -> None:
    trackers = scripted(beside)
    list(run_tasks(tasks[:1], tmp_path / "runs"))
    change(tasks[0])
    (outcome,) = run_tasks(tasks[:1], tmp_path / "runs")
    assert outcome.is_new
    assert len(trackers) == 2


def test_fewer_frames_or_other_code_are_run_anew(
    scripted: Callable,
    beside: Callable,
    tasks: list[Task],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scripted(beside)
    store = tmp_path / "runs"
    paths = [each.path for each in run_tasks(tasks[:1], store)]
    quick = [replace(tasks[0], most_frames=2)]
    (outcome,) = run_tasks(quick, store)
    assert len(outcome.run.frames) == 2
    paths.append(outcome.path)
    monkeypatch.setattr(benchmark_module, "code_version", lambda: "other")
    paths += [each.path for each in run_tasks(tasks[:1], store)]
    assert len(set(paths)) == 3


def test_a_damaged_run_is_made_again(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (outcome,) = run_tasks(tasks[:1], tmp_path / "runs")
    outcome.path.write_bytes(outcome.path.read_bytes()[:900])
    (again,) = run_tasks(tasks[:1], tmp_path / "runs")
    assert again.is_new
    (kept,) = run_tasks(tasks[:1], tmp_path / "runs")
    assert not kept.is_new


def test_an_unreadable_frame_stops_the_benchmark_and_keeps_what_is_finished(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (tasks[1].folder.directory / "color" / "004.jpg").write_bytes(b"no image")
    done: list[Outcome] = []
    with pytest.raises(FrameError, match=r"frame 004: .*004.jpg.*a benchmark needs every frame"):
        done.extend(run_tasks(tasks, tmp_path / "runs"))
    assert len(list((tmp_path / "runs").glob("*.npz"))) == 1


def test_a_store_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SourceError, match="file/runs: cannot be made: Not a directory"):
        RunStore(tmp_path / "file" / "runs")


def test_methods_are_checked_before_anything_is_read() -> None:
    check_methods(["icg"])
    with pytest.raises(TrackingError, match="there is no method 'magic'; the methods are icg"):
        check_methods(["icg", "magic"])
    with pytest.raises(TrackingError, match="no method to benchmark: name some of icg"):
        check_methods([])


@pytest.mark.slow
def test_side_by_side_the_real_tracker_says_the_same(dataset: Path, tmp_path: Path) -> None:
    tasks = [Task(folder, "icg", 3) for folder in find_sequences(dataset, conditions=["normal"])]
    alone = list(run_tasks(tasks, tmp_path / "alone"))
    apart = sorted(run_tasks(tasks, tmp_path / "apart", 2), key=lambda each: each.task.name)
    assert [each.circumstances.n_jobs for each in alone + apart] == [1, 1, 2, 2]
    for one, other in zip(alone, apart, strict=True):
        np.testing.assert_allclose(one.run.errors, other.run.errors, atol=1e-6)
    (tasks[0].folder.directory / "color" / "001.jpg").unlink()
    with pytest.raises(TrackingError, match=r"clamp-normal: icg: .*frame 001 is incomplete"):
        list(run_tasks(tasks, tmp_path / "damaged", 2))


def test_what_is_kept_names_its_machine(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (outcome,) = run_tasks(tasks[:1], tmp_path / "runs")
    with np.load(outcome.path) as file:
        facts = json.loads(str(file["facts"]))
    assert facts["machine"]["cpu"]
    assert facts["machine"]["n_cores"] >= 1
    assert facts["n_jobs"] == 1
    assert facts["commit"]
