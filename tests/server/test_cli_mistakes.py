"""`--split mistakes` and `benchmark --mistakes`: from a seed to the table, and clear errors."""

import json

import pytest
from typer.testing import CliRunner

from snapfit.server.cli.main import app

CLAMP = "hobby-corner-clamp"
runner = CliRunner(env={"COLUMNS": "200"})


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    out = tmp_path_factory.mktemp("mistakes")
    small = ["--asset", CLAMP, "--scale", "0.4", "--jobs", "1", "--count", "1"]
    result = runner.invoke(
        app, ["dataset", "render", "--split", "mistakes", "--out", str(out), *small]
    )
    assert result.exit_code == 0, result.output
    assert "1 sequences in" in result.output
    assert "wrong way round" in result.output
    return out


def benchmark(out, *more):
    return runner.invoke(app, ["benchmark", "--out", str(out), "--methods", "gbot", *more])


@pytest.mark.slow
def test_a_rendered_mistake_is_found_by_the_tracker(data, tmp_path):
    result = benchmark(tmp_path, "--mistakes", str(data))
    assert result.exit_code == 0, result.output
    assert "gbot: 1 of 1 found" in result.output
    record = json.loads((tmp_path / "mistakes.json").read_text())
    (sequence,) = record["sequences"]
    assert sequence["is_found"] is True
    assert 15 <= sequence["delay_frames"] <= 45
    assert sequence["false_events"] == []
    assert "| gbot | all | 1 | 100.0 |" in (tmp_path / "mistakes.md").read_text()


def test_there_is_nothing_to_judge(data, tmp_path):
    result = benchmark(tmp_path, "--mistakes", str(tmp_path))
    assert result.exit_code == 2
    assert "holds no sequence with a mistake" in result.stderr
    result = benchmark(tmp_path, "--mistakes", str(data), "--asset", "liftpod")
    assert result.exit_code == 2
    assert "has no mistakes of liftpod" in result.stderr


@pytest.mark.parametrize(
    "option",
    [["--data", "x"], ["--condition", "normal"], ["--quick"], ["--films"], ["--jobs", "2"]],
)
def test_options_of_the_other_benchmark_are_refused(tmp_path, option):
    result = benchmark(tmp_path, "--mistakes", str(tmp_path), *option)
    assert result.exit_code == 2
    assert f"{option[0]} does not go with --mistakes" in result.stderr


@pytest.mark.parametrize("option", [["--limit", "3"], ["--renderer", "cycles"], ["--masks"]])
def test_options_of_other_splits_are_refused(tmp_path, option):
    arguments = ["dataset", "render", "--split", "mistakes", "--out", str(tmp_path), *option]
    result = runner.invoke(app, arguments)
    assert result.exit_code == 2
    assert f"{option[0]} does not go with --split mistakes" in result.stderr
