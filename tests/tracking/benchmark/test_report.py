import json
import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.benchmark.benchmark import Outcome, Task, run_tasks
from snapfit.tracking.benchmark.plots import plot_errors
from snapfit.tracking.benchmark.report import Provenance, as_json, markdown, overall, rows_of
from snapfit.tracking.benchmark.scores import Score, mean_score, part_scores, run_score
from snapfit.tracking.benchmark.sequences import find_sequences, open_sequence
from snapfit.tracking.benchmark.side_by_side import panel_camera, pictures
from snapfit.tracking.errors import SourceError

PROVENANCE = Provenance("snapfit benchmark --data here", 6, "bench, seed 3")


@pytest.fixture
def outcomes(scripted: Callable, beside: Callable, dataset: Path, tmp_path: Path) -> list[Outcome]:
    """Runs that stand 2 mm beside the truth and lose the box in the last of six frames."""
    scripted(beside)
    return list(run_tasks([Task(each, "icg") for each in find_sequences(dataset)], tmp_path / "r"))


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
    assert box.time_ms == pytest.approx(1.5)
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
    assert "the first 6 of each sequence" in text
    assert "Times: one sequence at a time" in text
    assert "| clamp | blur | icg | 89.8 | 91.7 |" in text
    assert "| mean | overall | icg |" in text
    assert "| clamp | normal | icg | pin (s) |" in text


def test_times_of_sequences_side_by_side_are_marked(outcomes: list[Outcome]) -> None:
    apart = replace(outcomes[0].circumstances, n_jobs=2)
    text = markdown([replace(outcomes[0], circumstances=apart), outcomes[1]], PROVENANCE)
    assert "**Times are not to be trusted: 2 sequences ran side by side**" in text


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


def test_pictures_show_the_camera_and_each_method(outcomes: list[Outcome]) -> None:
    recording = open_sequence(outcomes[0].task.folder)
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
