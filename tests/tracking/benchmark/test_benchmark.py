import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.tracking.benchmark import contest, versions
from snapfit.tracking.benchmark.benchmark import Failure, Outcome, Plan, Task, run_tasks
from snapfit.tracking.benchmark.notes import Notes
from snapfit.tracking.benchmark.roster import (
    ablations,
    check_methods,
    needs_true_state,
    starts_cold,
)
from snapfit.tracking.benchmark.sequences import find_sequences, open_sequence
from snapfit.tracking.benchmark.store import RunStore
from snapfit.tracking.errors import FrameError, SourceError, TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import TrackingResult


@pytest.fixture
def tasks(dataset: Path) -> list[Task]:
    return [Task(folder, ("icg",)) for folder in find_sequences(dataset, ["clamp"])]


def ran(tasks: Sequence[Task], store: Path, n_jobs: int = 1, **more: bool) -> list[Outcome]:
    """What came out; nothing may have failed."""
    plan = Plan.of(tasks[0].methods, store, n_jobs, **more)
    outcomes = []
    for each in run_tasks(tasks, plan):
        assert isinstance(each, Outcome), each
        outcomes.append(each)
    return outcomes


def test_each_frame_is_judged_from_the_true_start(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    (outcome,) = ran(tasks[:1], tmp_path / "runs")
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
    assert run.confidences[0].tolist() == [0.9, 0.9]
    # 2 mm at a standard deviation of 1 mm in one of six directions; the pin has five.
    assert run.nees[0, :, 0] == pytest.approx([4 / 6, 4 / 5])
    assert np.isnan(run.nees[5, 0]).all()
    assert run.visibility[0, 0] == 1.0
    assert math.isnan(run.visibility[0, 1])
    assert (run.times_ms > 0).all()
    assert (run.cpu_ms > 0).all()
    assert run.misassembled.tolist() == [[False, f in (1, 2, 5)] for f in range(6)]
    assert run.true_states.tolist() == ["apart"] * 3 + ["joined"] * 3
    assert run.states.tolist() == ["apart"] * 4 + ["joined"] * 2


def test_a_method_that_remembers_nothing_is_not_shown_every_frame(
    scripted: Callable,
    beside: Callable,
    tasks: list[Task],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scripted(beside)
    (whole,) = ran(tasks[:1], tmp_path / "whole")
    monkeypatch.setattr(contest, "frame_step", lambda _: 2)
    scripted(lambda number, name, truth: beside(2 * number, name, truth))
    (outcome,) = ran(tasks[:1], tmp_path / "runs")
    run, rows = outcome.run, [0, 2, 4]
    assert run.frames.tolist() == whole.run.frames[rows].tolist()
    assert run.errors == pytest.approx(whole.run.errors[rows])
    assert run.true_states.tolist() == ["apart", "apart", "joined"]
    assert run.times_ms.shape == (3,)


def test_a_part_that_turns_about_its_axis_has_not_moved(
    scripted: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(lambda number, _, truth: truth @ Pose.exp([0, 0, 0.4 * number, 0, 0, 0]))
    (outcome,) = ran(tasks[:1], tmp_path / "runs")
    assert outcome.run.error("rotation_rad")[5] == pytest.approx([2.0, 0.0], abs=1e-6)
    # The axis is cut into 315 angles.
    assert outcome.run.error("mssd_m")[5, 1] <= 0.01 * math.pi / 315 + 1e-9
    assert outcome.run.nees[5, 1] == pytest.approx([0, 0, 0], abs=1e-6)


def test_what_is_finished_is_not_run_again(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    first = ran(tasks, tmp_path / "runs")
    assert len(trackers) == len(tasks) == 3
    again = ran(tasks, tmp_path / "runs")
    assert len(trackers) == 3
    assert [each.is_new for each in first + again] == [True] * 3 + [False] * 3
    for old, new in zip(first, again, strict=True):
        assert new.circumstances == old.circumstances
        assert new.run.parts == old.run.parts
        np.testing.assert_array_equal(new.run.errors, old.run.errors)
        np.testing.assert_array_equal(new.run.camera_from_body, old.run.camera_from_body)
        assert new.run.states.tolist() == old.run.states.tolist()


def test_every_frame_is_decoded_once_for_all_methods(
    scripted: Callable,
    beside: Callable,
    methods: dict,
    tasks: list[Task],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    trackers = scripted(beside)
    decoded: list[str] = []
    read = contest.read_frame

    def count(files: object, *rest: object) -> Frame:
        frame: Frame = read(files, *rest)
        decoded.append(frame.name)
        return frame

    monkeypatch.setattr(contest, "read_frame", count)
    outcomes = ran([replace(tasks[0], methods=("icg", "graph"))], tmp_path / "runs")
    assert [each.method for each in outcomes] == ["icg", "graph"]
    assert [each.circumstances.n_methods for each in outcomes] == [2, 2]
    assert decoded == ["000", "001", "002", "003", "004", "005"]
    assert [each.tracked for each in trackers] == [decoded, decoded]


def test_a_method_that_is_added_later_is_run_alone(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    ran(tasks[:1], tmp_path / "runs")
    outcomes = ran([replace(tasks[0], methods=("graph", "icg"))], tmp_path / "runs")
    assert [each.method for each in trackers] == ["icg", "graph"]
    assert [(each.method, each.is_new) for each in outcomes] == [("graph", True), ("icg", False)]


def test_a_method_that_is_told_the_state_hears_of_each_change(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    outcomes = ran([replace(tasks[0], methods=("told", "icg"))], tmp_path / "runs")
    assert [each.run.is_told_state for each in outcomes] == [True, False]
    assert trackers[0].told == [("apart", 0), ("joined", 3)]
    assert trackers[1].told == []


def test_without_true_states_a_method_that_needs_them_fails_alone(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    path = tasks[0].folder.directory / "gt.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    path.write_text(
        "\n".join(json.dumps({k: v for k, v in x.items() if k != "state"}) for x in lines)
    )
    plan = Plan.of(("told", "icg"), tmp_path / "runs")
    failure, outcome = run_tasks([replace(tasks[0], methods=("told", "icg"))], plan)
    assert isinstance(failure, Failure)
    assert (failure.method, outcome.method) == ("told", "icg")
    assert "needs the true state, and the ground truth of frame 000 has none" in failure.problem
    assert isinstance(outcome, Outcome)


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
    ran(tasks[:1], tmp_path / "runs")
    change(tasks[0])
    (outcome,) = ran(tasks[:1], tmp_path / "runs", any_code=True)
    assert outcome.is_new
    assert len(trackers) == 2


def test_fewer_frames_or_other_code_are_run_anew(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    store = tmp_path / "runs"
    paths = [each.path for each in ran(tasks[:1], store)]
    (outcome,) = ran([replace(tasks[0], most_frames=2)], store)
    assert len(outcome.run.frames) == 2
    paths.append(outcome.path)
    methods["icg"] = replace(methods["icg"], parameters=7)
    paths += [each.path for each in ran(tasks[:1], store)]
    assert len(set(paths)) == 3
    methods["icg"] = replace(methods["icg"], summary="in other words")
    (kept,) = ran(tasks[:1], store)
    assert (kept.path, kept.is_new) == (paths[-1], False)


def test_runs_of_other_code_stand_if_that_is_wanted_the_newest_first(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    trackers = scripted(beside)
    store = tmp_path / "runs"
    paths = []
    for age_s, parameters in ((50, 4), (10, 5), (90, 6)):
        methods["icg"] = replace(methods["icg"], parameters=parameters)
        (outcome,) = ran(tasks[:1], store)
        stamp = outcome.path.stat().st_mtime - age_s
        os.utime(outcome.path, (stamp, stamp))
        paths.append(outcome.path)
    methods["icg"] = replace(methods["icg"], parameters=8)
    (kept,) = ran(tasks[:1], store, any_code=True)
    assert (kept.path, kept.is_new) == (paths[1], False)
    assert len(trackers) == 3


def test_the_codes_version_is_that_of_what_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    names = {path.name for path in versions.imported_files()}
    assert {"contest.py", "metrics.py", "tracker.py", "refine.py", "viewpoint_build.py"} <= names
    assert not {"report.py", "plots.py", "shading.py"} & names
    version = versions.code_version("icg")
    assert versions.code_version("icg") == version
    monkeypatch.setattr(versions, "_ROOTS", ("contest",))
    assert versions.code_version("icg") == version  # it imports the other roots
    monkeypatch.setattr(versions, "_ROOTS", ("judge",))
    assert versions.code_version("icg") != version


def test_comments_do_not_change_the_codes_version(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    codes = []
    for text in ('"""Old."""\nx = 1\n', '"""New."""\n# Why.\nx = 1\n', "x = 2\n"):
        path.write_text(text)
        codes.append(versions._code_of(path))
    assert codes[0] == codes[1] != codes[2]


def test_a_damaged_run_is_made_again(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (outcome,) = ran(tasks[:1], tmp_path / "runs")
    outcome.path.write_bytes(outcome.path.read_bytes()[:900])
    (again,) = ran(tasks[:1], tmp_path / "runs")
    assert again.is_new
    (kept,) = ran(tasks[:1], tmp_path / "runs")
    assert not kept.is_new


def test_an_unreadable_frame_ends_its_sequence_and_the_others_go_on(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (tasks[1].folder.directory / "color" / "004.jpg").write_bytes(b"no image")
    plan = Plan.of(("icg",), tmp_path / "runs")
    first, failure, last = run_tasks(tasks, plan)
    assert isinstance(failure, Failure)
    assert failure.folder == tasks[1].folder
    assert "frame 004: " in failure.problem
    assert "004.jpg" in failure.problem
    assert "a benchmark needs every frame; render or copy it again" in failure.problem
    assert [each.folder for each in (first, last)] == [tasks[0].folder, tasks[2].folder]
    assert len(list((tmp_path / "runs").glob("*.npz"))) == 2


def test_an_incomplete_sequence_fails_and_the_others_go_on(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (tasks[0].folder.directory / "depth" / "003.png").unlink()
    failure, *others = run_tasks(tasks, Plan.of(("icg",), tmp_path / "runs"))
    assert isinstance(failure, Failure)
    assert "depth/003.png: no such file" in failure.problem
    assert all(isinstance(each, Outcome) for each in others)
    assert len(others) == 2


def test_a_method_that_cannot_go_on_does_not_stop_the_others(
    scripted: Callable, beside: Callable, methods: dict, tasks: list[Task], tmp_path: Path
) -> None:
    made: list = []

    def refuse(number: int, part: str, truth: Pose) -> Pose | None:
        # The second of the two has not come to this frame yet: it is the first that asks.
        if number == 3 and made[1].tracked[-1] == "002":
            raise FrameError("003", "is too dark")
        return beside(number, part, truth)

    made = scripted(refuse)
    plan = Plan.of(("icg", "graph"), tmp_path / "runs")
    failure, outcome = run_tasks([replace(tasks[0], methods=("icg", "graph"))], plan)
    assert isinstance(failure, Failure)
    assert (failure.method, failure.problem) == ("icg", "frame 003: is too dark")
    assert isinstance(outcome, Outcome)
    assert outcome.method == "graph"
    assert [len(each.tracked) for each in made] == [4, 6]


def test_an_answer_for_another_frame_is_refused(tasks: list[Task]) -> None:
    own = Notes(open_sequence(tasks[0].folder))
    result = TrackingResult("001", 0, (), 1.0)
    with pytest.raises(TrackingError, match="frame 000 was answered as 001"):
        own.take(0, result, (1.0, 1.0))
    own.take(1, result, (1.0, 1.0))


def test_a_store_that_cannot_be_written_is_told(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SourceError, match="file/runs: cannot be made: Not a directory"):
        RunStore(tmp_path / "file" / "runs")
    # Nothing that comes after it could be kept either: it stops everything.
    scripted(beside)
    (tmp_path / "runs").mkdir()
    plan = Plan.of(("icg",), tmp_path / "runs")
    (tmp_path / "runs").rmdir()
    (tmp_path / "runs").write_text("")
    with pytest.raises(SourceError, match="runs: cannot be made: File exists"):
        list(run_tasks(tasks, plan))


def test_methods_are_checked_before_anything_is_read() -> None:
    check_methods(["icg"])
    with pytest.raises(TrackingError, match=r"there is no method 'magic'; the methods are .*icg"):
        check_methods(["icg", "magic"])
    with pytest.raises(TrackingError, match=r"no method to benchmark: name some of .*icg"):
        check_methods([])


def test_what_is_special_of_a_method_stands_in_its_entry(methods: dict) -> None:
    assert [needs_true_state(name) for name in methods] == [False, False, True, False, False]
    assert [starts_cold(name) for name in methods] == [False, False, False, False, True]
    assert ablations(["icg", "graph", "graph-rigid"]) == {"graph": ("graph", "graph-rigid")}
    assert ablations(["icg", "graph-rigid"]) == {}


@pytest.mark.slow
def test_side_by_side_the_real_tracker_says_the_same(dataset: Path, tmp_path: Path) -> None:
    folders = find_sequences(dataset, conditions=["normal"])
    tasks = [Task(folder, ("icg",), 3) for folder in folders]
    alone = ran(tasks, tmp_path / "alone")
    apart = sorted(ran(tasks, tmp_path / "apart", 2), key=lambda each: each.folder.name)
    assert [each.circumstances.n_jobs for each in alone + apart] == [1, 1, 2, 2]
    n_cores = alone[0].circumstances.machine.n_cores
    assert {each.circumstances.n_threads for each in apart} == {max(n_cores // 2, 1)}
    for one, other in zip(alone, apart, strict=True):
        np.testing.assert_allclose(one.run.errors, other.run.errors, atol=1e-6)
    (tasks[0].folder.directory / "color" / "001.jpg").unlink()
    done = list(run_tasks(tasks, Plan.of(("icg",), tmp_path / "damaged", 2)))
    (failure,) = (each for each in done if isinstance(each, Failure))
    assert "frame 001 is incomplete" in failure.problem
    assert len(done) == 2


def test_what_is_kept_names_its_machine(
    scripted: Callable, beside: Callable, tasks: list[Task], tmp_path: Path
) -> None:
    scripted(beside)
    (outcome,) = ran(tasks[:1], tmp_path / "runs")
    with np.load(outcome.path) as file:
        facts = json.loads(str(file["facts"]))
    assert facts["machine"]["cpu"]
    assert facts["machine"]["n_cores"] >= 1
    assert (facts["n_jobs"], facts["n_methods"]) == (1, 1)
    assert facts["n_threads"] >= 1
    assert facts["commit"]
