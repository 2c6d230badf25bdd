"""Scenes written in BOP's format: read back the same, whole files only, a full disk is told."""

import errno
import json
import pickle
from pathlib import Path

import cv2
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.bop import load_bop_scene
from snapfit.models.bop_writer import BopWriter, instance, write_bytes, write_models
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import DatasetError
from snapfit.models.pose import Pose
from snapfit.models.sequence import load_sequence

CAMERA = PinholeCamera(64, 48, 60, 61, 31.5, 23.5)
RNG = np.random.default_rng(0)


@pytest.fixture(scope="module")
def asset():
    return find_asset("hobby-corner-clamp")


def pose_of(index, i):
    return Pose.exp([0.1 * i, 0.2, 0.01 * index, 0.01 * i, 0.02, 0.5 + 0.01 * index])


def write(writer, asset, index):
    color = np.full((48, 64, 3), 10 * index, np.uint8)
    depth = np.full((48, 64), 500 + index, np.uint16)
    poses = {part.name: pose_of(index, i) for i, part in enumerate(asset.tracked_parts)}
    masks = [np.zeros((48, 64), bool) for _ in poses]
    masks[0][3:9, 4:20] = True
    info = {"visib_fract": 0.25}
    entry = {
        "gt": [instance(part, poses[part.name]) for part in asset.tracked_parts],
        "info": [info for _ in poses],
        "poses": {name: pose.matrix.tolist() for name, pose in poses.items()},
        "visib": dict.fromkeys(poses, 0.25),
        "state": "parts-free",
    }
    writer.write(index, color, depth, masks, entry)


@pytest.fixture
def scene(asset, tmp_path):
    folder = tmp_path / asset.name / "test" / "normal"
    writer = BopWriter(folder, RgbdCamera(CAMERA, CAMERA))
    for index in (2, 0, 1):
        write(writer, asset, index)
    write_models(tmp_path / asset.name / "models", asset)
    writer.finish(asset, 30.0, "a test")
    return folder


def test_what_is_written_is_what_is_read(asset, scene):
    recording = load_bop_scene(scene)
    assert recording.camera.color == CAMERA
    assert recording.camera.depth_scale_m == pytest.approx(0.001)
    assert [frame.name for frame in recording.frames] == ["000000", "000001", "000002"]
    for index, truth in enumerate(recording.truth.values()):
        for i, part in enumerate(asset.tracked_parts):
            found = truth.camera_from_body[f"obj_{part.class_id:06d}"]
            assert found.distance_to(pose_of(index, i)) < 1e-8
            assert found.angle_to(pose_of(index, i)) < 1e-6
        assert set(truth.visibility.values()) == {0.25}
    for part in asset.tracked_parts:
        own = next(p for p in recording.parts if p.class_id == part.class_id)
        assert len(own.mesh.faces) == len(part.mesh.faces)
        assert own.mesh.diameter_m == pytest.approx(part.mesh.diameter_m, rel=1e-4)
        assert len(own.symmetry.motions) == len(part.symmetry.motions)


def test_the_same_folder_is_a_recorded_sequence(asset, scene):
    recording = load_sequence(scene)
    assert recording.asset.name == asset.name
    assert recording.initial_poses["jaw"].distance_to(pose_of(0, 1)) < 1e-9
    assert recording.truth["000002"].state == "parts-free"
    for files in recording.frames:
        assert cv2.imread(str(files.color)).shape == (48, 64, 3)
        assert cv2.imread(str(files.depth), cv2.IMREAD_UNCHANGED)[0, 0] == 500 + int(files.name)


def test_masks_and_sizes_are_bops(asset, scene):
    mask = cv2.imread(str(scene / "mask_visib" / "000001_000000.png"), cv2.IMREAD_UNCHANGED)
    assert mask.dtype == np.uint8
    assert set(np.unique(mask)) == {0, 255}
    assert (mask == 255).sum() == 6 * 16
    info = json.loads((scene.parents[1] / "models" / "models_info.json").read_text())
    base = info["0"]
    assert base["size_x"] == pytest.approx(160, abs=1)
    assert base["min_x"] == pytest.approx(-base["size_x"] / 2, abs=1)
    assert base["diameter"] > base["size_x"]


def test_a_frame_counts_when_all_of_it_is_there(asset, tmp_path, monkeypatch):
    writer = BopWriter(tmp_path, RgbdCamera(CAMERA, CAMERA))
    write(writer, asset, 0)
    real = Path.write_bytes

    def full(path, content):
        if "depth" in path.parts:
            real(path, content[:10])
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(DatasetError, match="disk is full; finished frames stay"):
        write(writer, asset, 1)
    assert writer.finished() == {0}
    assert [path.name for path in (tmp_path / "depth").iterdir()] == ["000000.png"]
    monkeypatch.undo()
    write(writer, asset, 1)
    assert writer.finished() == {0, 1}


def test_a_damaged_entry_is_made_anew(asset, tmp_path):
    writer = BopWriter(tmp_path, RgbdCamera(CAMERA, CAMERA))
    write(writer, asset, 0)
    (tmp_path / ".frames" / "000000.json").write_text("{")
    with pytest.raises(DatasetError, match="run the same again"):
        writer.entries()
    assert writer.finished() == set()


def test_a_scene_without_frames_is_refused(asset, tmp_path):
    with pytest.raises(DatasetError, match="no finished frame"):
        BopWriter(tmp_path, RgbdCamera(CAMERA, CAMERA)).finish(asset, 30.0, "")


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DatasetError, match="cannot be made"):
        BopWriter(tmp_path / "file" / "scene", RgbdCamera(CAMERA, CAMERA))
    with pytest.raises(DatasetError, match="cannot be written"):
        write_bytes(tmp_path / "nowhere" / "x", b"")


def test_the_error_comes_whole_from_another_process():
    error = pickle.loads(pickle.dumps(DatasetError(Path("a"), "is full")))
    assert str(error) == "a: is full"
    assert error.problem == "is full"
