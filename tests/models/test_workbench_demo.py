"""Rendered frames: the same bytes from a seed, and a ground truth that agrees with the pictures."""

import dataclasses
import hashlib
import json

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models import cache
from snapfit.models.asset import find_asset
from snapfit.models.camera import PinholeCamera
from snapfit.models.errors import WorkbenchError
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.sequence import load_sequence
from snapfit.models.workbench import demo
from snapfit.models.workbench.demo import Workbench, demo_sequence, render_demo
from snapfit.models.workbench.sensor import Sensor
from snapfit.models.workbench.visibility import visibility

N_FRAMES = 7
SEED = 11


@pytest.fixture(scope="module")
def asset():
    return find_asset("hobby-corner-clamp")


@pytest.fixture(scope="module")
def bench(asset):
    return Workbench(asset, SEED)


@pytest.fixture(scope="module")
def progress():
    return []


@pytest.fixture(scope="module")
def folder(asset, progress, tmp_path_factory):
    directory = tmp_path_factory.mktemp("demo")
    render_demo(directory, asset, n_frames=N_FRAMES, seed=SEED, progress=progress.append)
    return directory


@pytest.fixture(scope="module")
def recording(folder):
    return load_sequence(folder)


def test_the_sequence_is_complete_and_says_how_far_it_is(folder, recording, progress):
    assert len(recording.frames) == N_FRAMES
    assert progress == [(i + 1) / N_FRAMES for i in range(N_FRAMES)]
    for files in recording.frames:
        assert cv2.imread(str(files.color)).shape == (720, 1280, 3)
        depth = cv2.imread(str(files.depth), cv2.IMREAD_UNCHANGED)
        assert depth.shape == (720, 1280)
        assert depth.dtype == np.uint16


def test_tracking_can_start_from_the_truth_of_the_first_frame(folder, recording):
    first = json.loads((folder / "gt.jsonl").read_text().splitlines()[0])
    assert first["frame"] == recording.frames[0].name
    assert recording.initial_poses.keys() == {"base", "jaw", "bolt"}
    for name, pose in recording.initial_poses.items():
        np.testing.assert_allclose(pose.matrix, first["poses"][name], atol=1e-12)


def test_a_seed_gives_the_same_bytes(asset, bench):
    again = Workbench(asset, SEED)
    for time_s in (0.0, 3.4, 9.9):
        one, other = bench.frame("x", time_s), again.frame("x", time_s)
        assert hashlib.sha256(one.color).digest() == hashlib.sha256(other.color).digest()
        assert hashlib.sha256(one.depth).digest() == hashlib.sha256(other.depth).digest()


def test_the_order_of_rendering_does_not_matter(bench, folder, recording):
    middle = recording.frames[N_FRAMES // 2]
    time_s = bench.script.duration_s * (N_FRAMES // 2) / (N_FRAMES - 1)
    frame = bench.frame(middle.name, time_s)
    stored = cv2.imread(str(middle.depth), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(stored, frame.depth)
    difference = cv2.absdiff(cv2.imread(str(middle.color)), frame.color)
    assert difference.mean() < 2.5


def test_a_picture_painted_in_windows_is_the_same_as_one_painted_whole(bench):
    studio = bench._studio
    for move in bench.script.moves:
        time_s = (move.start_s + move.end_s) / 2
        poses = bench.script.poses_at(time_s)
        whole = studio.empty.copy()
        studio.paint(whole, poses, poses)
        difference = cv2.absdiff(whole, bench._clean(poses, time_s)).max(axis=-1)
        assert (difference > 8).mean() < 2e-4


@pytest.mark.parametrize("name", ["base", "jaw", "bolt"])
def test_depth_back_projected_lies_on_the_mesh_at_its_true_pose(asset, bench, name):
    part = next(part for part in asset.parts if part.name == name)
    frame = bench.frame("x", 4.0)
    poses = frame.truth.camera_from_body
    bodies = [(each.mesh, poses[each.name]) for each in asset.parts]
    label = asset.parts.index(part) + 1
    mask = render(bench.camera.color, bodies).part_id == label
    mask = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    rows, columns = np.nonzero(mask & (frame.depth > 0))
    pick = np.random.default_rng(0).choice(len(rows), 300, replace=False)
    rows, columns = rows[pick], columns[pick]
    camera = bench.camera.color
    z = frame.depth[rows, columns] * 0.001
    points = np.stack(
        [(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z]
    )
    own = poses[name].inverse().transform(points.T)
    surface = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
    _, distance_m, _ = trimesh.proximity.closest_point(surface, own)
    assert np.median(distance_m) < 0.0015
    assert np.quantile(distance_m, 0.9) < 0.004


def test_colour_shows_the_parts_where_the_truth_says(asset, bench):
    """The hue of pixels inside of each part's true outline is that of the part."""
    frame = bench.frame("x", 0.0)
    poses = frame.truth.camera_from_body
    seen = render(bench.camera.color, [(p.mesh, poses[p.name]) for p in asset.parts])
    for i, part in enumerate(asset.parts[:2]):
        mask = cv2.erode((seen.part_id == i + 1).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        around = cv2.dilate(mask.astype(np.uint8), np.ones((15, 15), np.uint8)) > 0
        around &= cv2.dilate((seen.part_id > 0).astype(np.uint8), np.ones((5, 5), np.uint8)) == 0
        direction = np.array(part.color_rgb[::-1], float) - 110
        inside = (frame.color[mask].astype(float) - 110) @ direction
        outside = (frame.color[around].astype(float) - 110) @ direction
        assert np.median(inside) > np.quantile(outside, 0.99)


def test_visibility_and_state_are_stated_for_every_frame(recording):
    states = [recording.truth[files.name].state for files in recording.frames]
    assert states[0] == "parts-free"
    assert states[-1] == "assembled"
    for truth in recording.truth.values():
        assert truth.visibility.keys() == {"base", "jaw", "bolt"}
        assert all(0 <= share <= 1 for share in truth.visibility.values())
    first, last = (recording.truth[recording.frames[i].name].visibility for i in (0, -1))
    assert min(first.values()) > 0.99
    assert last["base"] < 0.75
    assert last["jaw"] > 0.9


def test_a_hidden_part_has_visibility_zero_and_half_of_one_a_half():
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh = Mesh(box.vertices, box.faces)
    camera = PinholeCamera(200, 160, 300, 300, 99.5, 79.5)
    near, far = Pose.from_translation(0, 0, 0.5), Pose.from_translation(0, 0, 0.9)
    bodies = [(mesh, near), (mesh, far)]
    assert visibility(camera, bodies, render(camera, bodies).part_id) == [1.0, 0.0]
    edge = [(mesh, Pose.from_translation(-0.165, 0, 0.55))]
    (share,) = visibility(camera, edge, render(camera, edge).part_id)
    assert 0.4 < share < 0.65


def test_the_sensor_is_as_noisy_as_a_real_one(bench):
    camera = bench.camera.color
    sensor = Sensor(camera, np.random.default_rng(5))
    flat = np.full((camera.height, camera.width), 0.6, np.float32)
    frames = np.stack([sensor.depth(flat, np.random.default_rng(i)) for i in range(12)])
    middle = frames[:, 300:420, 560:720].astype(float)
    assert 0.7 < middle.std(axis=0).mean() < 1.4
    assert abs(middle.mean() - 600) < 2.5
    assert (frames[0][:, :100] == 0).all()
    grey = np.full((camera.height, camera.width, 3), 128, np.uint8)
    noisy = sensor.color(grey, np.random.default_rng(1)).astype(float)
    assert 1 < noisy.std() < 3
    assert abs(noisy.mean() - 128) < 0.2


def test_the_demo_is_rendered_once(asset, tmp_path, monkeypatch):
    calls = []

    def rendered(directory, asset, *, progress):
        calls.append(directory)
        (directory / "sequence.json").write_text("{}")

    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setattr(demo, "render_demo", rendered)
    first = demo_sequence(asset)
    assert (first / "sequence.json").is_file()
    assert demo_sequence(asset) == first
    assert len(calls) == 1
    painted = dataclasses.replace(asset.parts[0], color_rgb=(1, 2, 3))
    other = dataclasses.replace(asset, parts=(painted, *asset.parts[1:]))
    assert demo_sequence(other) != first
    assert [path.name for path in first.parent.iterdir() if path.name.startswith(".")] == []


def test_a_rendering_that_fails_leaves_nothing_behind(asset, tmp_path, monkeypatch):
    def broken(directory, asset, *, progress):
        (directory / "color").mkdir()
        raise WorkbenchError("the lamp broke")

    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setattr(demo, "render_demo", broken)
    with pytest.raises(WorkbenchError, match="lamp"):
        demo_sequence(asset)
    assert list((tmp_path / "demo").iterdir()) == []


@pytest.mark.parametrize(
    "name", ["geared-caliper", pytest.param("nano-chuck", marks=pytest.mark.slow)]
)
def test_any_asset_can_be_shown(name):
    asset = find_asset(name)
    bench = Workbench(asset, SEED)
    last = bench.frame("x", bench.script.duration_s)
    assert last.truth.state == asset.states[-1].name
    assert last.truth.camera_from_body.keys() == {part.name for part in asset.parts}
    for link in asset.states[-1].links:
        parent, child = (last.truth.camera_from_body[n] for n in (link.parent, link.child))
        assert (parent.inverse() @ child).distance_to(link.parent_from_child) < 1e-6


def test_a_sequence_without_frames_is_refused(asset, tmp_path):
    with pytest.raises(WorkbenchError, match="n_frames is 0"):
        render_demo(tmp_path, asset, n_frames=0)
