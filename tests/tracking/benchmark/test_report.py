import json
import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.benchmark.benchmark import Failure, Outcome, Plan, Task, run_tasks
from snapfit.tracking.benchmark.plots import plot_assets, plot_errors
from snapfit.tracking.benchmark.record import as_json
from snapfit.tracking.benchmark.report import Provenance, markdown, parts_markdown
from snapfit.tracking.benchmark.scores import Score, mean_score, part_scores, run_score
from snapfit.tracking.benchmark.sequences import find_sequences, open_sequence
from snapfit.tracking.benchmark.side_by_side import panel_camera, picture_size_px, pictures
from snapfit.tracking.benchmark.tables import by_condition, overall, rows_of
from snapfit.tracking.errors import SourceError

PROVENANCE = Provenance("snapfit benchmark --data here", 6, "bench, seed 3")


@pytest.fixture
def outcomes(scripted: Callable, beside: Callable, dataset: Path, tmp_path: Path) -> list[Outcome]:
    """Runs that stand 2 mm beside the truth and lose the box in the last of six frames."""
    return ran(scripted, beside, dataset, tmp_path, "icg")


def ran(
    scripted: Callable, beside: Callable, dataset: Path, tmp_path: Path, *names: str
) -> list[Outcome]:
    scripted(beside)
    tasks = [Task(each, names) for each in find_sequences(dataset)]
    done = list(run_tasks(tasks, Plan.of(names, tmp_path / "r")))
    assert all(isinstance(each, Outcome) for each in done)
    return done


def test_the_scores_are_those_of_a_calculation_by_hand(outcomes: list[Outcome]) -> None:
    box = part_scores(outcomes[0].run)["box"]
    assert box.add_score == pytest.approx(100 * 5 / 6 * 0.98)
    assert box.under_10_cm == pytest.approx(100 * 5 / 6)
    assert box.translation_cm == pytest.approx((5 * 0.2 + 10) / 6)
    assert box.rotation_deg == pytest.approx(180 / 6, abs=1e-6)
    assert box.add_recall == pytest.approx(100 * 5 / 6)
    assert box.add_auc == pytest.approx(100 * 5 / 6 * 0.9)
    # 2 mm of a diameter of 88 mm is below all thresholds from 5 % on; 0.26 of 64 pixels' width
    # are 2.6 px of 640.
    assert box.mssd_recall == pytest.approx(100 * 5 / 6)
    assert box.mspd_recall == pytest.approx(100 * 5 / 6)
    assert box.mssd_mm == pytest.approx(2)
    assert box.lost == pytest.approx(100 / 6)
    assert box.time_ms == pytest.approx(np.mean(outcomes[0].run.times_ms))
    assert box.cpu_ms == pytest.approx(np.mean(outcomes[0].run.cpu_ms))
    pin = part_scores(outcomes[0].run)["pin"]
    assert math.isnan(pin.rotation_deg)
    assert (pin.lost, pin.under_10_cm) == (0, 100)


def test_a_run_is_the_mean_of_its_parts_and_knows_its_states(outcomes: list[Outcome]) -> None:
    parts = part_scores(outcomes[0].run)
    whole = run_score(outcomes[0].run)
    for name in ("add_score", "add_recall", "add_auc", "mssd_recall", "mspd_recall", "lost"):
        mean = (getattr(parts["box"], name) + getattr(parts["pin"], name)) / 2
        assert getattr(whole, name) == pytest.approx(mean)
    assert whole.rotation_deg == parts["box"].rotation_deg
    assert whole.state_accuracy == pytest.approx(100 * 5 / 6)
    assert (whole.switch_delay, whole.switches_missed) == (1, 0)
    assert (whole.switches_found, whole.switches_beyond) == (100, 0)
    assert math.isnan(whole.settled_accuracy)


def test_states_that_a_method_was_told_are_no_merit(outcomes: list[Outcome]) -> None:
    told = replace(outcomes[0].run, is_told_state=True)
    assert math.isnan(run_score(told).state_accuracy)
    assert run_score(told).add_score == run_score(outcomes[0].run).add_score


def test_thresholds_of_mspd_grow_with_the_image(outcomes: list[Outcome]) -> None:
    run = outcomes[0].run
    errors = run.errors.copy()
    errors[:, 0, 4] = 26.0
    for width, expected in ((640, 50), (1280, 80), (320, 0)):
        score = part_scores(replace(run, errors=errors, image_width=width))["box"]
        assert score.mspd_recall == pytest.approx(expected)


def test_overall_means_the_papers_four_conditions(outcomes: list[Outcome]) -> None:
    rows = rows_of(outcomes)
    assert [row.condition for row in rows] == ["normal", "blur", "all", "normal"]
    marked = [
        replace(row, score=replace(row.score, add_score=value))
        for row, value in zip(rows, (90.0, 60.0, 0.0, 30.0), strict=True)
    ]
    means = {row.condition: row.score.add_score for row in overall(marked)}
    assert means == {"overall": pytest.approx(60.0), "all": 0.0}


def test_a_mean_leaves_out_who_does_not_answer() -> None:
    silent = Score(**{field.name: math.nan for field in fields(Score)})
    mean = mean_score([silent, replace(silent, lost=4.0), replace(silent, lost=6.0)])
    assert mean.lost == 5
    assert math.isnan(mean.add_auc)


def test_the_markdown_names_all_that_makes_it_again(outcomes: list[Outcome]) -> None:
    text = markdown(outcomes, PROVENANCE)
    assert "Command: `snapfit benchmark --data here`" in text
    assert "bench, seed 3" in text
    assert f"Commit: {outcomes[0].circumstances.commit}" in text
    assert outcomes[0].circumstances.machine.cpu in text
    assert "Frames: 24 in 4 sequences, the first 6 of each: a quick look, no result" in text
    assert "Times: one sequence at a time, on " in text
    overall_part, _, rest = text.partition("## By condition")
    assert "| overall | icg | 89.8 | 91.7 |" in overall_part
    assert "| all | icg | 89.8 | 91.7 |" in overall_part
    assert (
        "| condition | method | state | settled | found | missed | switch | beyond | alarms |"
        in text
    )
    assert "| blur | icg | 83.3 | - | 100.0 | 0.0 | 1.0 | 0.0 | 2.0 |" in rest
    assert "| clamp | box, pin (s) | normal, blur, all | 6 | 1 |" in text
    for title in ("clamp", "vise", "Lost parts", "Confidence and covariance", "How to read it"):
        assert f"\n## {title}\n" in text
    assert "| clamp | normal | icg | box 5- | 1 |" in text
    assert "What is left out of" not in text
    assert "missing here" not in text


def test_the_parts_have_a_page_of_their_own(outcomes: list[Outcome]) -> None:
    text = parts_markdown(outcomes)
    assert "| clamp | normal | icg | pin (s) |" in text
    assert "| vise | normal | icg | box | 81.7 | 83.3 |" in text


def test_what_is_missing_is_told_above_all_figures(outcomes: list[Outcome]) -> None:
    failures = [
        Failure(outcomes[0].folder, method, "frame 004: x.jpg: is no image")
        for method in ("icg", "graph")
    ]
    text = markdown(outcomes[1:], PROVENANCE, failures)
    begin, _, _ = text.partition("## Data")
    assert "**2 runs are missing here, and in the means:**" in begin
    assert "- clamp-normal, icg, graph: frame 004: x.jpg: is no image" in begin
    assert as_json(outcomes[1:], PROVENANCE, failures)["failures"][1] == {
        "sequence": "clamp-normal",
        "method": "graph",
        "problem": "frame 004: x.jpg: is no image",
    }


def test_told_methods_are_marked_and_ablations_have_a_table(
    scripted: Callable, beside: Callable, methods: dict, dataset: Path, tmp_path: Path
) -> None:
    names = ("graph", "graph-rigid", "told")
    outcomes = ran(scripted, beside, dataset, tmp_path, *names)
    text = markdown(outcomes, PROVENANCE)
    assert "| overall | told† |" in text
    assert "## Methods\n\n- `graph`: follows the graph\n\n## Data" in text
    _, _, section = text.partition("## What is left out of graph\n")
    table, _, _ = section.partition("## Lost parts")
    lines = [line.split(" | ")[:2] for line in table.strip().splitlines()[2:]]
    assert [" ".join(line).removeprefix("| ") for line in lines] == [
        "overall graph",
        "overall graph-rigid",
        "all graph",
        "all graph-rigid",
    ]
    states = [line for line in text.splitlines() if line.startswith("| normal | told†")]
    assert states
    assert not any("83.3 | - |" in line for line in states)
    content = as_json(outcomes, PROVENANCE)
    assert content["ablations"] == {"graph": ["graph", "graph-rigid"]}
    assert [row["is_told_state"] for row in content["rows"]] == [False, False, True] * 4


def test_means_by_condition_are_over_assets(outcomes: list[Outcome]) -> None:
    rows = rows_of(outcomes)
    marked = [
        replace(row, score=replace(row.score, add_score=value))
        for row, value in zip(rows, (90.0, 60.0, 0.0, 30.0), strict=True)
    ]
    means = [(row.condition, row.score.add_score) for row in by_condition(marked)]
    assert means == [("normal", 60.0), ("blur", 60.0), ("all", 0.0)]


def test_runs_of_several_commits_are_told_apart(outcomes: list[Outcome]) -> None:
    other = replace(outcomes[0].circumstances, commit="abc")
    mixed = [outcomes[0], replace(outcomes[1], method="graph", circumstances=other)]
    text = markdown(mixed, PROVENANCE)
    assert f"Commit: {outcomes[0].circumstances.commit} (icg); abc (graph)" in text


def test_times_of_sequences_side_by_side_are_marked(outcomes: list[Outcome]) -> None:
    apart = replace(outcomes[0].circumstances, n_jobs=2, n_threads=1)
    text = markdown([replace(outcomes[0], circumstances=apart)], PROVENANCE)
    assert "**Times are not to be trusted: 2 sequences ran side by side, on 1 thread each**" in text
    assert "`make bench` measures speed" in text


def test_times_of_a_busy_machine_are_marked(outcomes: list[Outcome]) -> None:
    circumstances = outcomes[0].circumstances
    n_cores = circumstances.machine.n_cores
    for load, is_busy in ((None, False), (n_cores - 0.5, False), (n_cores + 3.0, True)):
        busy = replace(outcomes[0], circumstances=replace(circumstances, load=load))
        text = markdown([busy], PROVENANCE)
        assert ("**Times are too long: 3.0 more processes than cores" in text) == is_busy


def test_the_json_holds_the_same_figures(outcomes: list[Outcome]) -> None:
    text = json.dumps(as_json(outcomes, PROVENANCE), allow_nan=False)
    content = json.loads(text)
    assert content["provenance"]["most_frames"] == 6
    row = content["rows"][1]
    assert (row["asset"], row["condition"], row["n_frames"]) == ("clamp", "blur", 6)
    assert row["score"]["lost"] == pytest.approx(100 / 12)
    assert row["parts"]["pin"]["rotation_deg"] is None
    assert row["circumstances"]["n_jobs"] == 1
    assert [mean["condition"] for mean in content["means"]] == ["overall", "all"]
    assert [each["condition"] for each in content["by_condition"]] == ["normal", "blur", "all"]
    assert row["losses"] == [{"part": "box", "first": 5, "last": 5, "comes_back": False}]
    own = {each["condition"]: each for each in content["calibration"]}
    assert list(own) == ["overall", "normal", "blur", "all"]
    assert own["all"]["statuses"]["lost"] == pytest.approx(1 / 12)
    assert own["all"]["consistency"]["translation"] == pytest.approx(4 / 3)
    assert own["all"]["reliability"]["right"][0] is None
    assert own["all"]["reliability"]["counts"][9] == 11


def test_the_plot_is_a_picture_with_a_line_a_part(outcomes: list[Outcome], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path = tmp_path / "clamp.png"
    further = outcomes[0].run.errors * np.array([5, 1])[:, None]
    plot_errors([replace(each.run, errors=further) for each in outcomes[:3]], path)
    image = cv2.imread(str(path))
    assert image is not None
    for color_bgr in ((115, 158, 0), (0, 159, 230)):
        near = np.abs(image.astype(int) - color_bgr).max(axis=2) < 40
        assert near.sum() > 100
    with pytest.raises(SourceError, match="cannot be written"):
        plot_errors([outcomes[0].run], tmp_path / "nowhere" / "clamp.png")


def test_of_many_methods_each_has_pictures_of_its_own(
    outcomes: list[Outcome], tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    runs = [replace(outcomes[0].run, method=f"m{i}") for i in range(4)]
    plot_assets(runs[:3], tmp_path)
    assert [path.name for path in tmp_path.glob("*.png")] == ["clamp.png"]
    plot_assets(runs, tmp_path)
    assert len(list(tmp_path.glob("clamp-m?.png"))) == 4


def test_many_methods_stand_in_a_grid(outcomes: list[Outcome]) -> None:
    recording = open_sequence(outcomes[0].folder)
    made = next(pictures(recording, [outcomes[0].run] * 5))
    assert made.shape == (2 * 48, 4 * 64, 3)
    assert picture_size_px(panel_camera(recording.camera.color), 5) == (4 * 64, 2 * 48)
    assert made[48:, : 2 * 64].any()
    assert not made[48:, 2 * 64 :].any()


def test_pictures_show_the_camera_and_each_method(outcomes: list[Outcome]) -> None:
    recording = open_sequence(outcomes[0].folder)
    made = list(pictures(recording, [outcomes[0].run, outcomes[0].run]))
    assert len(made) == 6
    assert made[0].shape == (48, 3 * 64, 3)
    below = made[0][24:]
    assert np.ptp(below[:, :64].astype(int), axis=2).max() < 15
    assert np.ptp(below[:, 64:128].astype(int), axis=2).max() > 40
    np.testing.assert_array_equal(below[:, 64:128], below[:, 128:])


def test_panels_have_even_sides() -> None:
    camera = panel_camera(PinholeCamera(1281, 723, 600, 600, 640, 361))
    assert (camera.width, camera.height) == (640, 360)
    small = PinholeCamera(64, 48, 60, 60, 31.5, 23.5)
    assert panel_camera(small) == small
