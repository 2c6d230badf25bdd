import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from snapfit.models.errors import ManifestError, SequenceError
from snapfit.tracking.benchmark.sequences import SequenceFolder, find_sequences, open_sequence


def names(folders: tuple[SequenceFolder, ...]) -> list[str]:
    return [folder.name for folder in folders]


def test_sequences_come_in_the_order_of_the_papers_table(dataset: Path) -> None:
    folders = find_sequences(dataset)
    assert names(folders) == ["clamp-normal", "clamp-blur", "clamp-all", "vise-normal"]
    assert folders[1].directory == dataset / "clamp" / "test" / "blur"


def test_assets_and_conditions_can_be_chosen(dataset: Path) -> None:
    assert names(find_sequences(dataset, ["clamp"], ["all", "normal"])) == [
        "clamp-normal",
        "clamp-all",
    ]
    assert names(find_sequences(dataset, ["vise"])) == ["vise-normal"]


def test_a_single_sequence_stands_for_itself(dataset: Path) -> None:
    inside = dataset / "clamp" / "test" / "blur"
    assert find_sequences(inside) == (SequenceFolder("clamp", "blur", inside),)
    alone = shutil.copytree(inside, dataset.parent / "take")
    assert names(find_sequences(alone)) == ["take-recorded"]


@pytest.mark.parametrize(
    ("assets", "conditions", "problem"),
    [
        (["lamp"], [], "has no asset 'lamp'; it has: clamp, vise"),
        ([], ["night"], "has no condition 'night'; it has: all, blur, normal"),
        (["vise"], ["blur"], "has no sequence of vise under blur"),
    ],
)
def test_what_is_not_there_is_told_with_what_is(
    dataset: Path, assets: list[str], conditions: list[str], problem: str
) -> None:
    with pytest.raises(SequenceError, match=problem):
        find_sequences(dataset, assets, conditions)


def test_a_folder_without_sequences_is_told(tmp_path: Path) -> None:
    with pytest.raises(SequenceError, match="no such folder: --data is a dataset"):
        find_sequences(tmp_path / "nowhere")
    with pytest.raises(SequenceError, match="holds no sequence: neither"):
        find_sequences(tmp_path)


def test_an_opened_sequence_starts_from_the_truth_and_ends_early_if_asked(dataset: Path) -> None:
    folder = find_sequences(dataset)[0]
    path = folder.directory / "sequence.json"
    content = json.loads(path.read_text())
    content["initial_poses"] = {"box": np.eye(4).tolist()}
    path.write_text(json.dumps(content))
    recording = open_sequence(folder, 2)
    assert [frame.name for frame in recording.frames] == ["000", "001"]
    truth = recording.truth["000"].camera_from_body
    assert set(recording.initial_poses) == {"box", "pin"}
    np.testing.assert_array_equal(recording.initial_poses["box"].matrix, truth["box"].matrix)


def cut_truth(folder: Path) -> None:
    lines = (folder / "gt.jsonl").read_text().splitlines()
    (folder / "gt.jsonl").write_text("\n".join(lines[:-2]))


def lengthen_truth(folder: Path) -> None:
    line = json.loads((folder / "gt.jsonl").read_text().splitlines()[0])
    with (folder / "gt.jsonl").open("a") as file:
        file.write(json.dumps(line | {"frame": "017"}) + "\n")


def forget_pin(folder: Path) -> None:
    lines = [json.loads(line) for line in (folder / "gt.jsonl").read_text().splitlines()]
    del lines[4]["poses"]["pin"]
    (folder / "gt.jsonl").write_text("\n".join(map(json.dumps, lines)))


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda folder: (folder / "color" / "002.jpg").unlink(), "frame 002 is incomplete"),
        (lambda folder: (folder / "depth" / "003.png").unlink(), "depth/003.png: no such file"),
        (lambda folder: (folder / "gt.jsonl").unlink(), "6 frames, but ground truth of 0"),
        (cut_truth, "6 frames, but ground truth of 4; without truth: 004, 005"),
        (lengthen_truth, "6 frames, but ground truth of 7; without images: 017"),
        (forget_pin, "frame 004: the ground truth has no pin"),
        (lambda folder: (folder / "box.ply").unlink(), "box.ply: there is no such mesh"),
    ],
)
def test_a_benchmark_refuses_what_is_incomplete(
    dataset: Path, damage: Callable[[Path], None], problem: str
) -> None:
    folder = find_sequences(dataset)[0]
    damage(folder.directory)
    with pytest.raises(Exception, match=problem) as caught:
        open_sequence(folder)
    assert str(folder.directory) in str(caught.value)


def as_bop(folder: Path) -> None:
    """Rewrites a sequence as a BOP scene, its object 1 being the box."""
    truths = [json.loads(line) for line in (folder / "gt.jsonl").read_text().splitlines()]
    camera = {"cam_K": [60, 0, 31.5, 0, 60, 23.5, 0, 0, 1], "depth_scale": 1.0}
    scene: dict[str, list[dict[str, object]]] = {}
    for i, truth in enumerate(truths):
        matrix = np.array(truth["poses"]["box"])
        pose = {
            "cam_R_m2c": matrix[:3, :3].ravel().tolist(),
            "cam_t_m2c": (1000 * matrix[:3, 3]).tolist(),
            "obj_id": 1,
        }
        scene[str(i)] = [pose]
    (folder / "scene_gt.json").write_text(json.dumps(scene))
    (folder / "scene_camera.json").write_text(json.dumps({"0": camera}))
    (folder / "color").rename(folder / "rgb")
    for path in [*(folder / "rgb").iterdir(), *(folder / "depth").iterdir()]:
        path.rename(path.with_name(f"000{path.name}"))
    (folder / "sequence.json").unlink()
    (folder / "gt.jsonl").unlink()


def test_a_bop_scene_is_read_with_the_datasets_own_meshes(dataset: Path) -> None:
    folder = find_sequences(dataset)[0]
    as_bop(folder.directory)
    with pytest.raises(ManifestError, match="clamp: no such folder and no bundled asset"):
        open_sequence(folder)
    models = folder.directory.parents[1] / "models"
    models.mkdir()
    box = (folder.directory / "box.ply").read_bytes()
    (models / "obj_000001.ply").write_bytes(box)
    with pytest.raises(Exception, match="Wrong unit"):
        open_sequence(folder)


@pytest.fixture
def bop_scene(dataset: Path) -> SequenceFolder:
    """A whole BOP scene with the meshes that it brings."""
    folder = find_sequences(dataset)[0]
    as_bop(folder.directory)
    (folder.directory / "models").mkdir()
    trimesh.creation.box((40, 50, 60)).export(folder.directory / "models" / "obj_000001.ply")
    return folder


def test_every_mask_of_a_bop_scene_must_be_there(bop_scene: SequenceFolder) -> None:
    masks = bop_scene.directory / "mask_visib"
    masks.mkdir()
    for image in range(6):
        (masks / f"{image:06d}_000000.png").write_bytes(b"")
    assert len(open_sequence(bop_scene).frames) == 6
    (masks / "000003_000000.png").unlink()
    with pytest.raises(SequenceError, match=r"mask_visib/000003_000000.png: no such file"):
        open_sequence(bop_scene)


def test_images_of_a_bop_scene_must_match_its_truth(bop_scene: SequenceFolder) -> None:
    folder = bop_scene
    scene = json.loads((folder.directory / "scene_gt.json").read_text())
    path = folder.directory / "scene_gt.json"
    path.write_text(json.dumps({**scene, "9": scene["0"]}))
    with pytest.raises(SequenceError, match="ground truth of 7; without images: 000009"):
        open_sequence(folder)
    path.write_text(json.dumps(scene))
    assert len(open_sequence(folder).frames) == 6


def test_the_published_dataset_is_found_and_opened(dataset: Path) -> None:
    published = (dataset / "clamp").rename(dataset / "HobbyCornerClamp")
    scene = published / "test" / "normal"
    as_bop(scene)
    names_there = ["Corner_Clamp_Base", "Corner_Clamp_Bolt", "Corner_Clamp_Jaw"]
    truth = json.loads((scene / "scene_gt.json").read_text())
    named = {i: [box | {"obj_id": name} for name in names_there] for i, (box,) in truth.items()}
    (scene / "scene_gt.json").write_text(json.dumps(named))
    (published / "models").mkdir()
    for name in names_there:
        trimesh.creation.box((40, 50, 60)).export(published / "models" / f"{name}.ply")
    (folder,) = find_sequences(dataset, ["HobbyCornerClamp"], ["normal"])
    recording = open_sequence(folder, 4)
    assert len(recording.frames) == 4
    assert [part.name for part in recording.parts] == names_there
    assert list(recording.initial_poses) == names_there
