"""Precision and recall in cluttered images: known answers, and a rendered set from end to end."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from snapfit.models.asset import find_asset
from snapfit.models.errors import DatasetError
from snapfit.models.pose import Pose
from snapfit.models.train_labels import Instance
from snapfit.models.workbench.train_set import TrainOrder, render_train_set
from snapfit.server.cli.main import app
from snapfit.tracking.benchmark import clutter
from snapfit.tracking.benchmark.clutter import (
    ImageJudge,
    Tally,
    check_can_detect,
    images_of,
    overlap,
)
from snapfit.tracking.benchmark.clutter_report import clutter_json, clutter_markdown, sums
from snapfit.tracking.detection.detector import Detection, Detections
from snapfit.tracking.errors import TrackingError

CLAMP = "hobby-corner-clamp"
HERE, THERE = Pose.from_translation(0, 0, 0.6), Pose.from_translation(0.15, 0, 0.6)
BOX = (100, 50, 40, 30)
runner = CliRunner(env={"COLUMNS": "250"})


def true(part: str, pose: Pose = HERE, seen: float = 1.0, box: Any = BOX) -> Instance:
    keypoints = np.zeros((17, 3), np.float32)
    n_seen = round(1000 * seen)
    return Instance(part, 1, pose, box, box, box, 1000, n_seen, n_seen, keypoints, "")


def said(part: str, pose: Pose = HERE, box: Any = BOX) -> Detection:
    left, top, width, height = box
    edges = np.array([left, top, left + width, top + height], dtype=np.float64)
    no_keypoints = np.zeros((0, 2)), np.zeros(0, np.float32), np.zeros(0, np.bool_)
    return Detection(part, 0.9, 0.9, edges, *no_keypoints, 1.0, pose)


def judged(found: list[Detection], instances: list[Instance], asset: str = CLAMP) -> Tally:
    tally = Tally(asset, "yolov8pose")
    ImageJudge(find_asset(asset)).add(tally, found, instances)
    return tally


def figures(tally: Tally) -> list[tuple[float, float]]:
    return [(tally.recall(each), tally.precision(each)) for each in clutter.CRITERIA]


def test_all_found_and_nothing_else_said() -> None:
    tally = judged([said("base"), said("jaw", THERE)], [true("base"), true("jaw", THERE)])
    assert figures(tally) == [(1, 1)] * 3


def test_each_criterion_by_itself() -> None:
    near = Pose.from_translation(0.05, 0, 0) @ HERE
    assert figures(judged([said("base", near)], [true("base")])) == [(1, 1), (1, 1), (0, 0)]
    far = Pose.from_translation(0.11, 0, 0) @ HERE
    assert figures(judged([said("base", far)], [true("base")])) == [(1, 1), (0, 0), (0, 0)]
    beside = (100, 72, 40, 30)
    assert figures(judged([said("base", box=beside)], [true("base")])) == [(0, 0), (1, 1), (1, 1)]


def test_what_is_said_of_another_part_is_wrong() -> None:
    assert figures(judged([said("jaw")], [true("base")])) == [(0, 0)] * 3


def test_a_part_that_is_said_twice_is_wrong_once() -> None:
    tally = judged([said("base"), said("base")], [true("base"), true("jaw", THERE)])
    assert figures(tally) == [(0.5, 0.5)] * 3
    # Unless it is there twice.
    tally = judged([said("base"), said("base", THERE)], [true("base"), true("base", THERE)])
    assert tally.recall("right") == tally.precision("right") == 1


def test_a_part_that_is_hardly_seen_need_not_be_said_and_may_be() -> None:
    hidden = [true("base"), true("jaw", THERE, seen=0.29)]
    assert figures(judged([said("base")], hidden)) == [(1, 1)] * 3
    assert figures(judged([said("base"), said("jaw", THERE)], hidden)) == [(1, 1)] * 3


def test_parts_of_one_mesh_stand_for_each_other() -> None:
    tally = judged([said("knob-2")], [true("knob-1")], "hand-screw-clamp")
    assert figures(tally) == [(1, 1)] * 3
    assert (tally.parts["knob-1"], tally.said["knob-2"]) == (1, 1)


def test_nothing_said_has_no_precision() -> None:
    tally = judged([], [true("base")])
    assert tally.recall("box") == 0
    assert math.isnan(tally.precision("box"))
    assert clutter_json([tally], "abc")["figures"][0]["precision_percent"]["box"] is None


def test_overlap_of_boxes() -> None:
    assert overlap(np.array([0.0, 0, 10, 10]), (0, 0, 10, 10)) == pytest.approx(1)
    assert overlap(np.array([5.0, 0, 15, 10]), (0, 0, 10, 10)) == pytest.approx(1 / 3)
    assert overlap(np.array([20.0, 0, 30, 10]), (0, 0, 10, 10)) == 0


def test_sums_are_over_parts_not_over_assets() -> None:
    few = judged([said("base")], [true("base")])
    many = judged([], [true("knob-1"), true("pad"), true("jaw-1")], "hand-screw-clamp")
    (total,) = sums([few, many])
    assert total.recall("right") == 0.25
    assert total.precision("right") == 1
    text = clutter_markdown([few, many], "abc")
    assert "| yolov8pose | all assets | 2 | 4 | 1 | 25.0 | 25.0 | 25.0 | 100.0 |" in text


def test_only_methods_that_look_at_single_images() -> None:
    check_can_detect(["yolov8pose", "yolov8pose+depth"])
    with pytest.raises(TrackingError, match="gbot does not look at single images"):
        check_can_detect(["gbot"])


@pytest.fixture(scope="module")
def sets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sets")
    render_train_set(TrainOrder(folder, (CLAMP,), 2, seed=21, depth=True, scale=0.25), jobs=1)
    return folder


class Truthful:
    """Says what is true of each image, and of every base another one beside it."""

    def __init__(self, folder: Path, *_: Any) -> None:
        self.camera: Any = None
        self._samples = {each.path.stem: each for each in images_of(folder)}

    def detect(self, frame: Any) -> Detections:
        assert frame.depth is not None
        labels = self._samples[frame.name].labels
        assert self.camera.color == labels.camera
        found = [
            said(each.part, each.camera_from_body, each.box_inside) for each in labels.instances
        ]
        aside = Pose.from_translation(0.5, 0, 0)
        found += [
            said(each.part, aside @ each.camera_from_body, (0, 0, 1, 1))
            for each in labels.instances
            if each.part == "base"
        ]
        return Detections(frame.name, tuple(found), duration_ms=3.0)


def test_a_rendered_set_from_the_command_to_the_page(
    sets: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clutter, "Detector", lambda *rest: Truthful(sets / CLAMP, *rest))
    page = tmp_path / "detector.md"
    page.write_text("# Mine\n\n<!-- benchmark -->\n<!-- /benchmark -->\n")
    out = tmp_path / "out"
    options = ["--clutter", str(sets), "--out", str(out), "--report", str(page)]
    result = runner.invoke(app, ["benchmark", *options, "--methods", "yolov8pose+depth"])
    assert result.exit_code == 0, result.output
    instances = [each for sample in images_of(sets / CLAMP) for each in sample.labels.instances]
    n_bases = sum(each.part == "base" for each in instances)
    (record,) = json.loads((out / "clutter.json").read_text())["figures"]
    assert record["images"] == 2
    assert record["recall_percent"]["right"] == 100
    expected = 100 * len(instances) / (len(instances) + n_bases)
    assert record["precision_percent"]["right"] == pytest.approx(expected, abs=0.01)
    assert "| yolov8pose+depth | hobby-corner-clamp | 2 |" in page.read_text()
    assert "seed 21" in page.read_text()


def test_an_asset_without_a_network_is_told(
    sets: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unlearnt = replace(find_asset(CLAMP), directory=tmp_path)
    monkeypatch.setattr(clutter, "find_asset", lambda _: unlearnt)
    options = ["--clutter", str(sets), "--out", str(tmp_path), "--methods", "yolov8pose-apart"]
    result = runner.invoke(app, ["benchmark", *options])
    assert result.exit_code == 2
    assert "hobby-corner-clamp: yolov8pose-apart:" in result.stderr
    assert "is missing" in result.stderr


def test_of_the_training_seed_only_validation_images_count(sets: Path, tmp_path: Path) -> None:
    assert [each.labels.index for each in images_of(sets / CLAMP)] == [0, 1]
    with pytest.raises(DatasetError, match="no finished training set"):
        images_of(tmp_path)
    copy = tmp_path / CLAMP / "train"
    copy.mkdir(parents=True)
    for path in (sets / CLAMP / "train").iterdir():
        (copy / path.name).symlink_to(path)
    recipe = json.loads((copy / "rendering.json").read_text())
    (copy / "rendering.json").unlink()
    (copy / "rendering.json").write_text(json.dumps({**recipe, "seed": 20}))
    with pytest.raises(DatasetError, match="all its images are for training"):
        images_of(tmp_path / CLAMP)


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        (["--data", "x"], "--data does not go with --clutter"),
        (["--recovery"], "--recovery does not go with --clutter"),
        (["--methods", "gbot"], "gbot does not look at single images"),
        (["--asset", "liftpod"], "holds no images of liftpod"),
    ],
)
def test_what_does_not_go_together_is_refused(
    sets: Path, tmp_path: Path, more: list[str], problem: str
) -> None:
    options = ["--clutter", str(sets), "--out", str(tmp_path), "--methods", "yolov8pose", *more]
    result = runner.invoke(app, ["benchmark", *options])
    assert result.exit_code == 2
    assert problem in result.stderr
