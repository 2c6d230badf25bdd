"""`snapfit dataset render --split train`: small images; options of the other split are refused."""

import pytest
from typer.testing import CliRunner

from snapfit.models.train_reader import TrainSet
from snapfit.server.cli.main import app

CLAMP = "hobby-corner-clamp"


def run(*arguments):
    return CliRunner().invoke(app, ["dataset", "render", *arguments])


def test_a_set_is_rendered_and_taken_up(tmp_path):
    small = ["--split", "train", "--asset", CLAMP, "--scale", "0.2", "--jobs", "1"]
    result = run(*small, "--count", "2", "--keypoints", "10", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "2 images rendered" in result.output
    result = run(*small, "--count", "3", "--keypoints", "10", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "1 images rendered" in result.output
    images = TrainSet(tmp_path / CLAMP)
    assert len(images) == 3
    assert [each.keypoints_m.shape for each in images.classes] == [(10, 3)] * 3
    result = run(*small, "--count", "3", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert "another rendering lies here (keypoints)" in result.output.replace("\n", " ")


@pytest.mark.parametrize(
    ("split", "option"),
    [
        ("train", ["--limit", "3"]),
        ("train", ["--condition", "normal"]),
        ("train", ["--renderer", "cycles"]),
        ("test", ["--count", "3"]),
        ("test", ["--depth"]),
        ("test", ["--masks"]),
        ("test", ["--keypoints", "9"]),
    ],
)
def test_options_of_the_other_split_are_refused(tmp_path, split, option):
    result = run("--split", split, *option, "--out", str(tmp_path))
    assert result.exit_code == 2
    assert f"{option[0]} does not go with --split {split}" in result.output
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_asset_is_refused(tmp_path):
    result = run("--split", "train", "--asset", "teapot", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert "no bundled asset" in result.output
