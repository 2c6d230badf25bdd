import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models.errors import MeshError, SequenceError
from snapfit.models.gbot_dataset import GBOT_ASSETS, is_gbot_scene, load_gbot_scene
from snapfit.models.pose import Pose

BASE, BOLT, JAW = "Corner_Clamp_Base", "Corner_Clamp_Bolt", "Corner_Clamp_Jaw"
N_IMAGES = 3


def true_pose(image: int, part: int) -> Pose:
    return Pose.exp([0.1 * image, 0.2, 0, 0.01 * part, 0, 0.5])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """The corner clamp in the published layout, with an untracked object beside its parts."""
    asset = tmp_path / "HobbyCornerClamp"
    scene = asset / "test" / "hand"
    for folder in (scene / "rgb", scene / "depth", asset / "models"):
        folder.mkdir(parents=True)
    for i, name in enumerate((BASE, BOLT, JAW)):
        trimesh.creation.box((40 + i, 50, 60)).export(asset / "models" / f"{name}.ply")
    info = {
        BOLT: {"diameter": 88, "symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 5]}]}
    }
    (asset / "models" / "models_info.json").write_text(json.dumps(info))
    truth: dict[str, list[dict[str, Any]]] = {}
    visibility: dict[str, list[dict[str, float]]] = {}
    for image in range(N_IMAGES):
        cv2.imwrite(str(scene / "rgb" / f"{image:06d}.png"), np.zeros((48, 64, 3), np.uint8))
        cv2.imwrite(str(scene / "depth" / f"{image:06d}.png"), np.zeros((48, 64), np.uint16))
        truth[str(image)] = [
            {
                "cam_R_m2c": true_pose(image, i).rotation.ravel().tolist(),
                "cam_t_m2c": (1000 * true_pose(image, i).translation).tolist(),
                "obj_id": name,
            }
            for i, name in enumerate(("Corner_Clamp_Spare", BASE, BOLT, JAW))
        ]
        visibility[str(image)] = [{"visib_fract": 0.1 * i} for i in range(4)]
    (scene / "scene_gt.json").write_text(json.dumps(truth))
    (scene / "scene_gt_info.json").write_text(json.dumps(visibility))
    camera = {"cam_K": [60, 0, 31.5, 0, 61, 23.5, 0, 0, 1], "depth_scale": 0.5}
    (scene / "scene_camera.json").write_text(json.dumps({"0": camera}))
    return scene


def test_a_scene_is_read_in_metres_with_its_part_names(scene: Path) -> None:
    assert is_gbot_scene(scene)
    recording = load_gbot_scene(scene)
    assert recording.name == "HobbyCornerClamp-hand"
    assert [frame.name for frame in recording.frames] == ["000000", "000001", "000002"]
    assert [part.name for part in recording.parts] == [BASE, BOLT, JAW]
    assert recording.parts[2].mesh.diameter_m == pytest.approx(
        math.dist((0, 0, 0), (0.042, 0.05, 0.06)), rel=1e-5
    )
    color = recording.camera.color
    assert (color.width, color.height, color.fx, color.fy) == (64, 48, 60, 61)
    assert recording.camera.depth_scale_m == pytest.approx(0.0005)
    truth = recording.truth["000002"]
    np.testing.assert_allclose(
        truth.camera_from_body[JAW].matrix, true_pose(2, 3).matrix, atol=1e-9
    )
    assert truth.visibility == pytest.approx({BASE: 0.1, BOLT: 0.2, JAW: 0.3})
    assert recording.initial_poses is recording.truth["000000"].camera_from_body


def test_symmetries_are_those_that_the_dataset_states(scene: Path) -> None:
    base, bolt, _ = load_gbot_scene(scene).parts
    assert base.symmetry.is_none
    assert bolt.symmetry.axis is not None
    np.testing.assert_allclose(bolt.symmetry.axis.point_m, (0, 0, 0.005))


def test_a_part_that_the_paper_calls_symmetric_is_so_even_if_nothing_says_how(scene: Path) -> None:
    (scene.parents[1] / "models" / "models_info.json").unlink()
    base, bolt, _ = load_gbot_scene(scene).parts
    assert base.symmetry.is_none
    assert not bolt.symmetry.is_none
    for motion in bolt.symmetry.sampled(0.001, 0.05):
        np.testing.assert_array_equal(motion.matrix, np.eye(4))


def test_the_papers_parts_are_all_there() -> None:
    n_parts = {name: len(parts) for name, parts in GBOT_ASSETS.items()}
    assert n_parts == {
        "GearedCaliper": 3,
        "HobbyCornerClamp": 3,
        "NanoViseV2": 8,
        "Hand_ScrewClamp": 7,
        "Liftpod": 7,
    }
    assert sum(sum(parts.values()) for parts in GBOT_ASSETS.values()) == 15


def test_other_folders_are_none_of_the_dataset(scene: Path) -> None:
    other = scene.parents[1].rename(scene.parents[2] / "SomeLamp") / "test" / "hand"
    assert not is_gbot_scene(other)
    with pytest.raises(SequenceError, match="'SomeLamp' is no asset of the GBOT dataset: Geared"):
        load_gbot_scene(other)


def edit_truth(change: Callable[[dict[str, Any]], Any]) -> Callable[[Path], None]:
    def damage(scene: Path) -> None:
        path = scene / "scene_gt.json"
        content = json.loads(path.read_text())
        change(content)
        path.write_text(json.dumps(content))

    return damage


def remove(name: str) -> Callable[[Path], None]:
    return lambda scene: (scene / name).unlink()


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (remove("scene_gt.json"), "scene_gt.json: cannot be read: No such file"),
        (remove("scene_camera.json"), "scene_camera.json: cannot be read: No such file"),
        (edit_truth(lambda truth: truth.pop("0")), "nothing is said of the first image 000000"),
        (edit_truth(lambda truth: truth["1"][2].pop("obj_id")), r"1\[2\].obj_id: is missing"),
        (
            edit_truth(lambda truth: truth["1"][2].update(cam_R_m2c=[2.0] * 9)),
            f"image 1: {BOLT}: the rotation is not orthonormal",
        ),
        (
            lambda scene: (scene.parents[1] / "models").rename(scene / "meshes"),
            "no folder `models` with the parts' meshes",
        ),
    ],
)
def test_a_broken_scene_is_told_by_file_and_key(
    scene: Path, damage: Callable[[Path], None], problem: str
) -> None:
    damage(scene)
    with pytest.raises(SequenceError, match=problem):
        load_gbot_scene(scene)


def test_a_missing_mesh_is_told(scene: Path) -> None:
    (scene.parents[1] / "models" / f"{JAW}.ply").unlink()
    with pytest.raises(MeshError, match=f"{JAW}.ply: there is no such mesh file"):
        load_gbot_scene(scene)
