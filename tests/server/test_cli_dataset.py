"""`snapfit dataset render`: small pictures of a few frames; what is there is kept; clear errors."""

import errno
import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from snapfit.models.sequence import load_sequence
from snapfit.models.workbench import dataset
from snapfit.models.workbench.split import Condition
from snapfit.server.cli.dataset import Backend, ConditionName
from snapfit.server.cli.main import app
from snapfit.tracking.sources import open_source

CLAMP = "hobby-corner-clamp"
SMALL = ["--asset", CLAMP, "--scale", "0.2", "--jobs", "1"]


def render(out, *more):
    return CliRunner().invoke(app, ["dataset", "render", "--out", str(out), *SMALL, *more])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("dataset")
    result = render(out, "--limit", "4")
    assert result.exit_code == 0, result.output
    return out


def test_all_conditions_are_there_and_play_as_sequences(folder):
    assert {path.name for path in (folder / CLAMP / "test").iterdir()} == set(Condition)
    for condition in Condition:
        scene = folder / CLAMP / "test" / condition
        recording = load_sequence(scene)
        assert len(recording.frames) == len(recording.truth) == 4
        source = open_source(scene)
        frame = source.read()
        source.close()
        assert frame is not None
        info = json.loads((scene / "scene_gt_info.json").read_text())
        shares = recording.truth["000001"].visibility
        assert [each["visib_fract"] for each in info["1"]] == list(shares.values())
        mask = cv2.imread(str(scene / "mask_visib" / "000001_000000.png"), cv2.IMREAD_UNCHANGED)
        assert np.count_nonzero(mask) == info["1"][0]["px_count_visib"]


def test_the_summary_states_what_was_measured(folder):
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["frames"] == 20
    assert summary["last_rendering"]["frames"] == 20
    blur = summary["scenes"][f"{CLAMP}/blur"]
    assert blur["exposure_share"] >= 0.5
    assert blur["frames_per_core_second"] > 0
    assert blur["states"] == ["parts-free"]


def test_finished_frames_are_kept_and_the_rest_is_made(folder, tmp_path, monkeypatch):
    scene = folder / CLAMP / "test" / "normal"
    before = (scene / "rgb" / "000002.jpg").read_bytes()
    when = (scene / "rgb" / "000001.jpg").stat().st_mtime_ns
    (scene / ".frames" / "000002.json").unlink()
    (scene / "rgb" / "000002.jpg").unlink()
    result = render(folder, "--limit", "4", "--condition", "normal")
    assert result.exit_code == 0, result.output
    assert (scene / "rgb" / "000002.jpg").read_bytes() == before
    assert (scene / "rgb" / "000001.jpg").stat().st_mtime_ns == when
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["last_rendering"]["frames"] == 1
    assert len(summary["scenes"]) == len(Condition)


def test_a_full_disk_leaves_valid_frames_and_the_run_is_taken_up(tmp_path, monkeypatch):
    real = Path.write_bytes

    def full(path, content):
        if "000002.jpg" in path.name:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    result = render(tmp_path, "--limit", "3", "--condition", "normal")
    assert result.exit_code == 1
    assert "disk is full; finished frames stay" in result.output.replace("\n", "")
    scene = tmp_path / CLAMP / "test" / "normal"
    assert len(list((scene / ".frames").glob("*.json"))) == 2
    assert not (scene / "sequence.json").exists()
    monkeypatch.undo()
    result = render(tmp_path, "--limit", "3", "--condition", "normal")
    assert result.exit_code == 0, result.output
    assert len(load_sequence(scene).frames) == 3


def test_another_rendering_in_the_folder_is_refused(folder):
    result = render(folder, "--limit", "4", "--seed", "21")
    assert result.exit_code == 1
    assert "another rendering lies here (seed)" in result.output
    (folder / CLAMP / "test" / "hand" / "rendering.json").write_text("{")
    result = render(folder, "--limit", "4", "--condition", "hand")
    assert result.exit_code == 1
    assert "is not valid JSON" in result.output


def test_an_unknown_asset_is_refused(tmp_path):
    arguments = ["dataset", "render", "--out", str(tmp_path), "--asset", "teapot"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1
    assert "no bundled asset" in result.output
    assert CLAMP in result.output


def test_an_asset_outside_of_the_split_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(dataset, "TEST_FRAMES", {"teapot": 10})
    result = render(tmp_path)
    assert result.exit_code == 1
    assert "is not in the test split, which has: teapot" in result.output.replace("\n", "")


@pytest.mark.parametrize(("backend", "module"), [("ray", "ray"), ("dask", "distributed")])
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_backend_that_is_not_installed_is_told(tmp_path, monkeypatch, backend, module, jobs):
    monkeypatch.setitem(sys.modules, module, None)
    arguments = [*SMALL, "--limit", "1", "--condition", "normal", "--backend", backend]
    arguments[arguments.index("--jobs") + 1] = jobs
    result = CliRunner().invoke(app, ["dataset", "render", "--out", str(tmp_path), *arguments])
    assert result.exit_code == 1
    problem = f"backend {backend} is not installed: pip install 'snapfit[{backend}]', or use loky"
    assert problem in result.output.replace("\n", " ")


def test_the_command_knows_the_conditions_of_the_workbench():
    assert [each.value for each in ConditionName] == [each.value for each in Condition]
    assert [each.value for each in Backend] == ["loky", "ray", "dask"]


def test_cycles_without_blender_is_told_before_anything_is_made(tmp_path, monkeypatch):
    monkeypatch.setattr("snapfit.models.workbench.blender.find_spec", lambda _: None)
    monkeypatch.setitem(sys.modules, "bpy", None)
    result = render(tmp_path / "dataset", "--renderer", "cycles", "--limit", "1")
    assert result.exit_code == 1
    assert "pip install 'snapfit[blender]'" in result.stderr
    assert not (tmp_path / "dataset").exists()
