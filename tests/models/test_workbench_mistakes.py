"""Wrong assemblies: a part rests, touching, through nothing, where it does not belong."""

import json
import math

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from snapfit.models.asset import find_asset
from snapfit.models.errors import DatasetError, SequenceError, WorkbenchError
from snapfit.models.pose import Pose
from snapfit.models.sequence import load_sequence
from snapfit.models.workbench import mistakes
from snapfit.models.workbench.bench import sampled_scene
from snapfit.models.workbench.mistake import (
    MISTAKE_NAME,
    MistakeKind,
    find_mistakes,
    read_mistake,
)
from snapfit.models.workbench.mistake_set import MistakeOrder, MistakeRun, render_mistakes
from snapfit.models.workbench.mistakes import MistakeMaker, n_frames_of
from snapfit.models.workbench.split import FRAME_RATE_HZ, TEST_FRAMES, Condition
from snapfit.tracking.assembly.graph import AssemblyGraph

CLAMP = "hobby-corner-clamp"
CASES = [
    (CLAMP, MistakeKind.WRONG_PLACE, 3),
    (CLAMP, MistakeKind.WRONG_PART, 3),
    (CLAMP, MistakeKind.WRONG_ORDER, 11),
    ("geared-caliper", MistakeKind.WRONG_WAY_ROUND, 3),
    ("liftpod", MistakeKind.WRONG_PLACE, 3),
    pytest.param("hand-screw-clamp", MistakeKind.WRONG_WAY_ROUND, 3, marks=pytest.mark.slow),
    pytest.param("nano-chuck", MistakeKind.WRONG_PART, 3, marks=pytest.mark.slow),
    pytest.param("nano-chuck", MistakeKind.WRONG_PLACE, 3, marks=pytest.mark.slow),
    pytest.param("liftpod", MistakeKind.WRONG_ORDER, 3, marks=pytest.mark.slow),
    pytest.param("hand-screw-clamp", MistakeKind.WRONG_PART, 3, marks=pytest.mark.slow),
]


def made(name, kind, seed):
    asset = find_asset(name)
    scene = sampled_scene(seed, [part.color_rgb for part in asset.parts])
    return asset, *MistakeMaker(asset, scene, seed).make(kind)


def solid(asset, name, poses):
    mesh = next(part.mesh for part in asset.parts if part.name == name)
    return trimesh.Trimesh(poses[name].transform(mesh.vertices) * 1000, mesh.faces)


@pytest.mark.parametrize(("name", "kind", "seed"), CASES)
def test_a_part_rests_where_it_does_not_belong(name, kind, seed):
    asset, script, mistake = made(name, kind, seed)
    assert mistake.kind is kind
    last = n_frames_of(script) - 1
    assert last - mistake.rest_frame >= 1.2 * FRAME_RATE_HZ
    rest, before, end = (
        script.poses_at(frame / FRAME_RATE_HZ)
        for frame in (mistake.rest_frame, mistake.rest_frame - 6, last)
    )
    part = mistake.part
    assert all(rest[each].distance_to(end[each]) < 1e-6 for each in rest)
    assert before[part].distance_to(rest[part]) > 1e-4
    assert {script.state_at(t) for t in (0.0, script.duration_s)} == {mistake.state}
    others = [each for each in rest if each != part]
    own = solid(asset, part, rest)
    assert own.vertices[:, 2].min() > -2.0
    for other in others:
        body = solid(asset, other, rest)
        common = trimesh.boolean.intersection([own, body], engine="manifold")
        volume = 0.0 if common.is_empty else common.volume
        assert volume < 0.05 * min(own.volume, body.volume), other
    if kind is not MistakeKind.WRONG_ORDER:
        beside = solid(asset, mistake.parent, rest)
        points = [np.vstack([each.sample(60_000, seed=0), each.vertices]) for each in (beside, own)]
        gaps, _ = cKDTree(points[0]).query(points[1])
        assert gaps.min() < 1.5
    _is_off(asset, mistake, rest)


def _is_off(asset, mistake, rest):
    """By the tracker's own measure, which knows joints and symmetries."""
    graph = AssemblyGraph(asset)
    fits = [
        measure.fit((rest[measure.link.parent].inverse() @ rest[measure.link.child]).matrix)
        for measure in graph.coming(mistake.state)
        if mistake.part in (measure.link.parent, measure.link.child)
    ]
    assert not any(fit.is_within_tolerance for fit in fits)
    if mistake.kind is MistakeKind.WRONG_PLACE:
        assert all(fit.translation_m > fit.link.translation_tolerance_m for fit in fits)
        assert 0.015 < mistake.translation_m < 0.15
    if mistake.kind is MistakeKind.WRONG_WAY_ROUND:
        assert all(math.degrees(fit.rotation_rad) > 20 for fit in fits)
    if mistake.kind in (MistakeKind.WRONG_ORDER, MistakeKind.WRONG_PART):
        assert not fits
    if mistake.kind is MistakeKind.WRONG_ORDER:
        later = [
            measure.fit((rest[measure.link.parent].inverse() @ rest[measure.link.child]).matrix)
            for measure in graph.later(mistake.state)
            if measure.link.child == mistake.part
        ]
        assert any(fit.translation_m < 1e-3 and fit.is_within_tolerance for fit in later)


def test_a_seed_gives_the_same_mistake_and_another_seed_another():
    one, again, other = (made(CLAMP, MistakeKind.WRONG_PLACE, seed) for seed in (3, 3, 4))
    assert one[2] == again[2]
    for share in (0.0, 0.4, 1.0):
        poses = [script.poses_at(share * script.duration_s) for _, script, _ in (one, again)]
        for name, pose in poses[0].items():
            assert np.array_equal(pose.matrix, poses[1][name].matrix)
    assert one[2] != other[2]


def test_where_no_shape_allows_a_kind_another_one_is_taken():
    # The beam's only neighbour in size is too small to take its place.
    _, _, mistake = made("geared-caliper", MistakeKind.WRONG_PART, 3)
    assert mistake.kind is not MistakeKind.WRONG_PART


def test_an_asset_of_which_nothing_is_seen_is_refused(monkeypatch):
    monkeypatch.setattr(mistakes, "_LEAST_SEEN", 1.1)
    with pytest.raises(WorkbenchError, match="no part of 'hobby-corner-clamp' can be put wrongly"):
        made(CLAMP, MistakeKind.WRONG_PLACE, 3)


def test_assets_and_kinds_come_in_turn(tmp_path):
    order = MistakeOrder(tmp_path, tuple(TEST_FRAMES), 64, (Condition.NORMAL, Condition.HAND))
    runs = [MistakeRun(order, i) for i in range(64)]
    first = {(run.asset, run.kind) for run in runs[:20]}
    assert len(first) == 20
    assert {run.condition for run in runs[:20]} == {Condition.NORMAL}
    assert {run.condition for run in runs[20:40]} == {Condition.HAND}
    assert len({run.seed for run in runs}) == 64


@pytest.fixture(scope="module")
def order(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mistakes")
    order = MistakeOrder(folder, (CLAMP,), count=1, seed=3, scale=0.15)
    done = []
    summary = render_mistakes(order, jobs=1, progress=lambda *counts: done.append(counts))
    assert done == [(0, 1), (1, 1)]
    assert summary["frames"] > 80
    return order


def test_a_sequence_lies_on_disk_with_its_truth(order):
    (found,) = find_mistakes(order.directory)
    assert found.asset == CLAMP
    mistake, recording = read_mistake(found.directory), load_sequence(found.directory)
    assert len(recording.frames) == len(recording.truth) > mistake.rest_frame + 45
    assert {truth.state for truth in recording.truth.values()} == {mistake.state}
    info = json.loads((found.directory / "scene_gt_info.json").read_text())
    column = [part.name for part in recording.parts].index(mistake.part)
    assert abs(info[str(mistake.rest_frame)][column]["visib_fract"] - mistake.visibility) < 0.15
    poses = [
        recording.truth[f"{i:06d}"].camera_from_body[mistake.part]
        for i in (0, mistake.rest_frame, len(recording.frames) - 1)
    ]
    assert poses[0].distance_to(poses[1]) > 0.02
    assert poses[1].distance_to(poses[2]) < 1e-6
    assert isinstance(poses[0], Pose)


def test_what_is_finished_is_kept_and_what_is_missing_made(order):
    assert render_mistakes(order, jobs=1)["frames"] == 0
    folder = find_mistakes(order.directory)[0].directory
    truth, picture = (folder / MISTAKE_NAME).read_bytes(), folder / "rgb" / "000005.jpg"
    pixels = picture.read_bytes()
    (folder / MISTAKE_NAME).unlink()
    (folder / ".frames" / "000005.json").unlink()
    picture.unlink()
    assert render_mistakes(order, jobs=1)["frames"] == 1
    assert (folder / MISTAKE_NAME).read_bytes() == truth
    assert picture.read_bytes() == pixels


def test_another_rendering_in_the_folder_is_refused(order):
    other = MistakeOrder(order.directory, (CLAMP,), count=1, seed=4, scale=0.15)
    with pytest.raises(DatasetError, match="another rendering lies here"):
        render_mistakes(other, jobs=1)


def test_truth_that_is_missing_or_damaged_is_told(tmp_path):
    with pytest.raises(SequenceError, match="holds no sequence with a mistake"):
        find_mistakes(tmp_path)
    with pytest.raises(SequenceError, match=r"mistake\.json.*render the split mistakes again"):
        read_mistake(tmp_path)
    (tmp_path / MISTAKE_NAME).write_text('{"kind": "odd"}')
    with pytest.raises(SequenceError, match=r"kind: .*render it again"):
        read_mistake(tmp_path)
