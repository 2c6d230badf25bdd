"""The training split: the same bytes from a seed, labels that agree with what is drawn, resumed."""

import errno
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import canonical_pose
from snapfit.models.rasteriser import render
from snapfit.models.rle import decode_mask
from snapfit.models.train_labels import OUTSIDE, VISIBLE
from snapfit.models.train_reader import TrainSet
from snapfit.models.train_writer import COCO_NAME
from snapfit.models.ultralytics_layout import LEAST_PIXELS, LEAST_VISIBILITY
from snapfit.models.workbench.train_set import TrainOrder, render_train_set

ASSET = "nano-chuck"
COUNT = 14


def order(folder, **changes):
    given = {"count": COUNT, "scale": 0.5, "depth": True, **changes}
    return TrainOrder(folder, (ASSET,), **given)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("train")
    figures = render_train_set(order(out), jobs=1)
    assert figures["last_rendering"]["images"] == COUNT
    return out


@pytest.fixture(scope="module")
def samples(folder):
    return TrainSet(folder / ASSET)


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_the_same_seed_gives_the_same_bytes_in_any_order(folder, tmp_path):
    """Broken off after each of two calls, and with the images asked for in another number."""
    render_train_set(order(tmp_path, count=5), jobs=1)
    assert len(TrainSet(tmp_path / ASSET)) == 5
    render_train_set(order(tmp_path), jobs=1)
    assert contents(tmp_path) == contents(folder)


def test_half_of_the_images_show_joined_parts(samples):
    states = {state.name for state in find_asset(ASSET).states if state.links}
    assembled = [sample.labels for sample in samples if sample.labels.is_assembled]
    assert len(samples) == COUNT
    assert len(assembled) == COUNT // 2
    assert {labels.state for labels in assembled} <= states


def test_joined_parts_stand_as_their_state_says(samples):
    """Fixed links hold exactly, up to the parts' symmetry."""
    asset = find_asset(ASSET)
    parts = {part.name: part for part in asset.parts}
    states = {state.name: state for state in asset.states}
    checked = 0
    for sample in samples:
        if not sample.labels.is_assembled:
            continue
        poses = {each.part: each.camera_from_body for each in sample.labels.instances}
        for link in states[sample.labels.state].links:
            if link.joint.type != "fixed" or not {link.parent, link.child} <= set(poses):
                continue
            if not parts[link.parent].symmetry.is_none:
                continue
            expected = poses[link.parent] @ link.parent_from_child
            nearest = parts[link.child].symmetry.nearest(poses[link.child], expected)
            assert nearest.distance_to(expected) < 1e-6
            checked += 1
    assert checked > 0


def test_boxes_are_those_of_the_rendered_outline(samples):
    parts = {part.name: part for part in find_asset(ASSET).parts}
    for sample in samples:
        camera = sample.labels.camera
        for each in sample.labels.instances:
            alone = render(camera, [(parts[each.part].mesh, each.camera_from_body)]).part_id > 0
            rows, columns = np.flatnonzero(alone.any(axis=1)), np.flatnonzero(alone.any(axis=0))
            x, y, across, down = each.box_inside
            outline = columns[0] - x, rows[0] - y, columns[-1] + 1 - x, rows[-1] + 1 - y
            assert np.abs(np.subtract(outline, (0, 0, across, down))).max() <= 1
            # What is seen lies in it, but for the edges of pixels.
            assert not (each.mask(camera) & ~cv2.dilate(alone.astype(np.uint8), KERNEL)).any()


KERNEL = np.ones((5, 5), np.uint8)


def test_visible_keypoints_lie_on_what_is_seen_of_the_part(samples):
    n_visible = n_all = 0
    for sample in samples:
        camera = sample.labels.camera
        for each in sample.labels.instances:
            around = cv2.dilate(each.mask(camera).astype(np.uint8), KERNEL)
            for u, v, seen in each.keypoints:
                inside = -0.5 <= u <= camera.width - 0.5 and -0.5 <= v <= camera.height - 0.5
                assert inside == (seen != OUTSIDE)
                if seen == VISIBLE:
                    assert around[round(float(v)), round(float(u))]
                    n_visible += 1
                n_all += 1
    assert 0.2 * n_all < n_visible < 0.7 * n_all


def test_keypoints_are_those_of_the_pose_and_the_pose_is_canonical(samples):
    parts = {part.name: part for part in find_asset(ASSET).parts}
    points = {each.part: each.keypoints_m for each in samples.classes}
    for sample in samples:
        for each in sample.labels.instances:
            pose = each.camera_from_body
            projected = sample.labels.camera.project(pose.transform(points[each.part]))
            np.testing.assert_allclose(each.keypoints[:, :2], projected, atol=0.02)
            chosen = canonical_pose(pose, parts[each.part].symmetry)
            assert chosen.angle_to(pose) < 1e-5


def test_every_part_and_occlusion_turn_up(samples):
    seen = [each for sample in samples for each in sample.labels.instances]
    assert {each.part for each in seen} == {each.part for each in samples.classes}
    assert any(each.visibility < 0.6 for each in seen)
    assert any(each.visibility == 1.0 for each in seen)


def test_the_ultralytics_layout_says_the_same(folder, samples):
    root = folder / ASSET / "ultralytics"
    text = (root / "data.yaml").read_text()
    assert "kpt_shape: [17, 3]" in text
    # Found wherever the folder is, and nothing is mirrored.
    assert not {"path", "flip_idx"} & {line.split(":")[0] for line in text.splitlines()}
    assert f'  0: "{samples.classes[0].part}"' in text
    n_labels = 0
    for sample in samples:
        labels, camera = sample.labels, sample.labels.camera
        split = "val" if labels.is_validation else "train"
        image = root / "images" / split / f"{labels.index:06d}.jpg"
        assert image.read_bytes() == sample.path.read_bytes()
        lines = (root / "labels" / split / f"{labels.index:06d}.txt").read_text().splitlines()
        kept = [
            each
            for each in labels.instances
            if each.visibility >= LEAST_VISIBILITY and each.n_seen >= LEAST_PIXELS
        ]
        assert len(lines) == len(kept)
        for line, each in zip(lines, kept, strict=True):
            numbers = [float(word) for word in line.split()]
            assert len(numbers) == 5 + 3 * 17
            assert samples.classes[int(numbers[0])].part == each.part
            assert all(0 <= number <= 1 for number in numbers[1:5])
            size = np.array([camera.width, camera.height])
            middle, extent = numbers[1:3] * size, numbers[3:5] * size
            np.testing.assert_allclose(
                [*(middle - extent / 2), *extent], each.box_inside, atol=0.01
            )
            points = np.array(numbers[5:]).reshape(17, 3)
            np.testing.assert_array_equal(points[:, 2], each.keypoints[:, 2])
            inside = points[:, 2] != OUTSIDE
            places = points[inside, :2] * size - 0.5
            np.testing.assert_allclose(places, each.keypoints[inside, :2], atol=0.02)
            assert (points[~inside, :2] == 0).all()
            n_labels += 1
    assert n_labels > 3 * COUNT


def test_scenes_say_the_same_as_bop_and_as_coco(folder, samples):
    scene = folder / ASSET / "train" / "000000"
    truth = json.loads((scene / "scene_gt.json").read_text())
    info = json.loads((scene / "scene_gt_info.json").read_text())
    cameras = json.loads((scene / "scene_camera.json").read_text())
    assert list(truth) == list(info) == list(cameras) == [str(i) for i in range(COUNT)]
    for sample in samples:
        key = str(sample.labels.index)
        for entry, seen, each in zip(truth[key], info[key], sample.labels.instances, strict=True):
            assert entry["obj_id"] == each.class_id
            translation = np.array(entry["cam_t_m2c"]) / 1000
            np.testing.assert_allclose(translation, each.camera_from_body.translation, atol=1e-6)
            assert seen["visib_fract"] == round(each.visibility, 6)
            assert tuple(seen["bbox_obj"]) == each.box
        assert cameras[key]["cam_K"][0] == pytest.approx(sample.labels.camera.fx, abs=1e-5)
    coco = json.loads((scene / COCO_NAME).read_text())
    assert [each["id"] for each in coco["images"]] == list(range(COUNT))
    first = samples[0].labels
    own = [each for each in coco["annotations"] if each["image_id"] == 0]
    for entry, each in zip(own, first.instances, strict=True):
        height, width = entry["segmentation"]["size"]
        mask = decode_mask(entry["segmentation"]["counts"], height, width)
        assert mask.sum() == entry["area"] == each.n_seen
        assert entry["num_keypoints"] == (each.keypoints[:, 2] != OUTSIDE).sum()
    assert not (scene / ".frames").exists()


def test_depth_is_that_of_the_parts(folder, samples):
    sample = samples[1]
    depth = cv2.imread(str(sample.path.parents[1] / "depth" / "000001.png"), cv2.IMREAD_UNCHANGED)
    parts = {part.name: part for part in find_asset(ASSET).parts}
    each = max(sample.labels.instances, key=lambda each: each.n_seen)
    alone = render(sample.labels.camera, [(parts[each.part].mesh, each.camera_from_body)])
    both = each.mask(sample.labels.camera) & (depth > 0) & (alone.depth > 0)
    assert abs(np.median(depth[both] - 1000 * alone.depth[both])) < 3


def test_masks_are_written_as_files_on_request(tmp_path):
    render_train_set(order(tmp_path, count=1, depth=False, masks=True), jobs=1)
    (sample,) = TrainSet(tmp_path / ASSET)
    folder = sample.path.parents[1]
    assert not (folder / "depth").exists()
    for i, each in enumerate(sample.labels.instances):
        path = folder / "mask_visib" / f"000000_{i:06d}.png"
        mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(mask > 0, each.mask(sample.labels.camera))


def test_a_full_disk_leaves_valid_images_and_the_run_is_taken_up(folder, tmp_path, monkeypatch):
    real = Path.write_bytes

    def full(path, content):
        if "000003.jpg" in path.name:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(DatasetError, match="disk is full; finished frames stay"):
        render_train_set(order(tmp_path, count=6), jobs=1)
    assert len(list((tmp_path / ASSET / "train/000000/.frames").glob("*.json"))) == 3
    monkeypatch.undo()
    counts = []
    render_train_set(order(tmp_path), jobs=1, progress=lambda done, _: counts.append(done))
    assert counts[0] == 3
    assert contents(tmp_path) == contents(folder)


def test_another_set_in_the_folder_is_refused(folder):
    with pytest.raises(DatasetError, match=r"another rendering lies here \(seed\)"):
        render_train_set(order(folder, seed=3), jobs=1)


def test_a_folder_without_a_set_is_told(tmp_path):
    with pytest.raises(DatasetError, match="no finished training set"):
        TrainSet(tmp_path)


@pytest.fixture
def damaged(tmp_path):
    render_train_set(order(tmp_path, count=2, depth=False, scale=0.2), jobs=1)
    return tmp_path / ASSET


def test_damage_is_told_with_its_place(damaged):
    path = damaged / "train" / "000000" / "labels.jsonl"
    lines = path.read_text().splitlines()
    path.write_text(f"{lines[0]}\n{lines[1][:90]}\n")
    with pytest.raises(DatasetError, match=r"labels.jsonl: line 2 is damaged"):
        TrainSet(damaged)
    path.write_text("")
    with pytest.raises(DatasetError, match="holds no image"):
        TrainSet(damaged)
    (damaged / "train" / "set.json").write_text("{}")
    with pytest.raises(DatasetError, match=r"set.json: is damaged"):
        TrainSet(damaged)


def test_a_missing_image_is_told(damaged):
    sample = TrainSet(damaged)[1]
    sample.path.unlink()
    with pytest.raises(DatasetError, match=r"000001.jpg: is missing"):
        sample.image()


def test_a_damaged_entry_is_made_anew(damaged):
    entries = damaged / "train" / "000000" / ".frames"
    entries.mkdir()
    (entries / "000002.json").write_text("{")
    again = order(damaged.parent, count=3, depth=False, scale=0.2)
    with pytest.raises(DatasetError, match="was damaged and is gone: run the same again"):
        render_train_set(again, jobs=1)
    assert render_train_set(again, jobs=1)["last_rendering"]["images"] == 1
    assert len(TrainSet(damaged)) == 3


def test_where_the_disk_knows_no_links_images_are_copied(folder, tmp_path, monkeypatch):
    def refuse(path, source):
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(Path, "hardlink_to", refuse)
    render_train_set(order(tmp_path, count=2), jobs=1)
    for name in ("000000.jpg", "000001.jpg"):
        own, linked = (
            each / ASSET / "ultralytics/images/train" / name for each in (tmp_path, folder)
        )
        assert own.read_bytes() == linked.read_bytes()
        assert own.stat().st_nlink == 1
        assert linked.stat().st_nlink == 2


def test_a_lost_image_is_told_when_the_layout_is_written(damaged):
    (damaged / "train/000000/rgb/000001.jpg").unlink()
    (damaged / "ultralytics/images/train/000001.jpg").unlink()
    with pytest.raises(DatasetError, match=r"000001.jpg: is missing: remove the scene's folder"):
        render_train_set(order(damaged.parent, count=2, depth=False, scale=0.2), jobs=1)


def test_one_in_twenty_is_kept_for_validation(samples):
    from snapfit.models.train_labels import Labels

    camera = samples[0].labels.camera
    kept = [i for i in range(400) if Labels(i, camera, None, ()).is_validation]
    assert len(kept) == 20
    assert sum(i % 2 for i in kept) == 10
    assert len(samples.selected(validation=False)) == COUNT
    assert len(samples.selected(validation=False, assembled=True)) == COUNT // 2
    assert samples.selected(validation=True) == []


# The last, because it needs another stock of surfaces.
def test_another_seed_gives_another_image(folder, tmp_path, samples):
    render_train_set(order(tmp_path, count=1, seed=21), jobs=1)
    other = TrainSet(tmp_path / ASSET)[0]
    assert (other.image() != samples[0].image()).mean() > 0.5
