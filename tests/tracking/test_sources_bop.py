import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import load_asset
from snapfit.models.bop import load_bop_scene
from snapfit.models.errors import SequenceError
from snapfit.tracking.sources import open_source

CAMERA = {"cam_K": [60, 0, 31.5, 0, 61, 23.5, 0, 0, 1], "depth_scale": 0.1}


def instance(obj_id: int, z_mm: float) -> dict[str, Any]:
    return {"cam_R_m2c": np.eye(3).ravel().tolist(), "cam_t_m2c": [0, 10, z_mm], "obj_id": obj_id}


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A BOP data set with two objects, one of them there twice, and one scene of three images."""
    models = tmp_path / "models"
    models.mkdir()
    for obj_id in (1, 5):
        trimesh.creation.box((40, 50, 60)).export(models / f"obj_{obj_id:06d}.ply")
    info = {"1": {"diameter": 87.7}, "5": {"symmetries_continuous": [{"axis": [0, 0, 1]}]}}
    (models / "models_info.json").write_text(json.dumps(info))
    scene = tmp_path / "test" / "000002"
    for folder in ("rgb", "depth"):
        (scene / folder).mkdir(parents=True)
    for i in range(3):
        cv2.imwrite(str(scene / "rgb" / f"{i:06d}.png"), np.full((48, 64, 3), i, np.uint8))
        cv2.imwrite(str(scene / "depth" / f"{i:06d}.png"), np.full((48, 64), 5000 + i, np.uint16))
    write(scene, "scene_camera.json", {str(i): CAMERA for i in range(3)})
    truth = {str(i): [instance(5, 500 + i), instance(1, 600), instance(5, 700)] for i in range(3)}
    write(scene, "scene_gt.json", truth)
    visible = {str(i): [{"visib_fract": share} for share in (1.0, 0.5, 0.25)] for i in range(3)}
    write(scene, "scene_gt_info.json", visible)
    return scene


def write(scene: Path, name: str, content: Any) -> None:
    (scene / name).write_text(json.dumps(content))


def test_a_scene_is_played_in_metres(scene: Path) -> None:
    source = open_source(scene)
    frame = source.read()
    source.close()
    assert frame is not None
    assert frame.name == "000000"
    assert frame.depth is not None
    assert frame.depth[0, 0] * source.camera.depth_scale_m == pytest.approx(0.5)
    assert (source.camera.color.fx, source.camera.color.cy) == (60, 23.5)
    assert source.camera.depth == source.camera.color
    assert [part.name for part in source.parts] == ["obj_000001", "obj_000005", "obj_000005_2"]
    assert [part.symmetry.kind for part in source.parts] == ["none", "axis", "axis"]
    assert source.parts[0].mesh.diameter_m == pytest.approx(0.0877, abs=1e-4)
    assert source.initial_poses["obj_000005"].translation == pytest.approx((0, 0.01, 0.5))
    assert source.initial_poses["obj_000005_2"].translation == pytest.approx((0, 0.01, 0.7))
    assert source.truth["000002"].camera_from_body["obj_000005"].translation[2] == 0.502
    assert source.truth["000002"].visibility["obj_000005_2"] == 0.25


def test_an_asset_gives_the_parts_by_class_id(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "asset.toml").write_text(
        '[asset]\nname = "a"\ntitle = "A"\nlicence = "MIT"\nmesh_unit_m = 0.001\n'
        '[[part]]\nname = "jaw"\nmesh = "models/obj_000001.ply"\nclass_id = 1\n'
    )
    recording = load_bop_scene(scene, load_asset(tmp_path))
    assert [part.name for part in recording.parts] == ["jaw"]
    assert list(recording.initial_poses) == ["jaw"]
    assert recording.truth["000001"].visibility == {"jaw": 0.5}


def test_the_camera_of_the_first_image_may_hold_for_all(scene: Path) -> None:
    write(scene, "scene_camera.json", {"0": CAMERA})
    assert len(load_bop_scene(scene).frames) == 3


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("scene_camera.json", {"0": CAMERA, "1": CAMERA | {"depth_scale": 1}}, "1: the camera ch"),
        ("scene_camera.json", {"0": {"cam_K": [1, 2]}}, r"0\.cam_K: .*at least 9 items"),
        ("scene_camera.json", {"0": CAMERA | {"cam_K": [0] * 9}}, r"cam_K: .*fx is 0"),
        ("scene_camera.json", {"0": CAMERA | {"depth_scale": 0}}, r"0\.depth_scale: .*than 0"),
        ("scene_camera.json", {}, "is empty"),
        ("scene_gt.json", {"0": [{"obj_id": 1}]}, r"0\[0\]\.cam_R_m2c: is missing"),
        ("scene_gt.json", {"0": [instance(5, float("nan"))]}, "image 0: obj_000005: .*finite"),
        ("scene_gt.json", {"0": [instance(1, 1) | {"cam_R_m2c": [0] * 9}]}, "obj_000001: .*ortho"),
    ],
)
def test_a_broken_scene_names_file_and_key(
    scene: Path, name: str, content: Any, problem: str
) -> None:
    write(scene, name, content)
    with pytest.raises(SequenceError, match=problem) as caught:
        load_bop_scene(scene)
    assert str(caught.value).startswith(str(scene / name))


def test_a_scene_without_meshes_is_told_where_to_get_them(scene: Path) -> None:
    (scene.parent.parent / "models").rename(scene.parent.parent / "elsewhere")
    with pytest.raises(SequenceError, match="no `models` folder: name one, or give an asset"):
        load_bop_scene(scene)
    recording = load_bop_scene(scene, models=scene.parent.parent / "elsewhere")
    assert len(recording.parts) == 3


def test_a_scene_without_images_is_refused(scene: Path) -> None:
    (scene / "rgb").rename(scene / "pictures")
    with pytest.raises(SequenceError, match="no folder of images: one of rgb, color, gray"):
        load_bop_scene(scene)
