"""The assembly of every asset of the test split: as fast as stated, in view, the right states."""

import itertools
import math

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.errors import WorkbenchError
from snapfit.models.pose import Pose
from snapfit.models.workbench.assembly import timed_assembly
from snapfit.models.workbench.motion import Swing, Tremor, Twist
from snapfit.models.workbench.mounting import assembly_path, joined, plan_mounts
from snapfit.models.workbench.scene import standard_scene
from snapfit.models.workbench.speed import moving_part, speed_of
from snapfit.models.workbench.split import FRAME_RATE_HZ, TEST_FRAMES

NAMES = ("hobby-corner-clamp", "geared-caliper")


@pytest.fixture(scope="module")
def scene():
    return standard_scene(np.random.default_rng(1))


@pytest.fixture(scope="module", params=NAMES)
def played(request, scene):
    asset = find_asset(request.param)
    n = TEST_FRAMES[asset.name]
    script = timed_assembly(asset, scene, n, 20)
    return asset, script, [script.poses_at(i / FRAME_RATE_HZ) for i in range(n)]


def test_the_split_is_that_of_the_paper():
    assert TEST_FRAMES == {
        "nano-chuck": 900,
        "hobby-corner-clamp": 400,
        "geared-caliper": 500,
        "hand-screw-clamp": 750,
        "liftpod": 900,
    }


def test_a_moved_part_goes_at_the_stated_speed(played):
    asset, script, frames = played
    speed = speed_of(script, len(frames), frozenset(p.name for p in asset.tracked_parts))
    assert speed.median_mm == pytest.approx(3, abs=0.3)
    assert speed.median_deg == pytest.approx(1.5, abs=0.15)
    assert speed.peak_mm > 10
    assert speed.peak_deg > 5
    assert speed.moving_share > 0.4


def test_all_lie_apart_on_the_bench_and_in_view_at_first(played, scene):
    asset, _, frames = played
    for part in asset.parts:
        points = frames[0][part.name].transform(part.mesh.vertices)
        assert points[:, 2].min() == pytest.approx(0, abs=1e-5)
        pixels = scene.camera.project(scene.camera_from_world.transform(points))
        assert (pixels > 0).all()
        assert (pixels < [1280, 720]).all()


def test_nothing_leaves_the_picture_or_goes_deep_into_the_bench(played, scene):
    asset, _, frames = played
    for poses in frames[::10]:
        for part in asset.parts:
            points = poses[part.name].transform(part.mesh.vertices)
            middle = points.mean(axis=0)
            pixel = scene.camera.project(scene.camera_from_world.transform(middle[None]))[0]
            assert 0 < pixel[0] < 1280
            assert 0 < pixel[1] < 720
            assert points[:, 2].min() > -0.02


def test_the_state_changes_in_the_frame_in_which_a_part_reaches_its_place(played):
    asset, script, frames = played
    names = [script.state_at(i / FRAME_RATE_HZ) for i in range(len(frames))]
    assert list(dict.fromkeys(names)) == [
        asset.states[0].name,
        *(step.to_state for step in assembly_path(asset)),
    ]
    states = {state.name: state for state in asset.states}
    for a, b in itertools.pairwise(dict.fromkeys(names)):
        first = names.index(b)
        old = {(link.parent, link.child) for link in states[a].links}
        new = [link for link in states[b].links if (link.parent, link.child) not in old]
        for link in new:
            relative = frames[first][link.parent].inverse() @ frames[first][link.child]
            assert relative.distance_to(link.parent_from_child) < 1e-6
        before = [frames[first - 1][e.parent].inverse() @ frames[first - 1][e.child] for e in new]
        moved = [
            pose.distance_to(e.parent_from_child) + pose.angle_to(e.parent_from_child)
            for pose, e in zip(before, new, strict=True)
        ]
        assert max(moved) > 1e-6


def test_what_is_joined_moves_as_one(played):
    asset, script, frames = played
    states = {state.name: state for state in asset.states}
    for i in range(0, len(frames), 7):
        for link in states[script.state_at(i / FRAME_RATE_HZ)].links:
            relative = frames[i][link.parent].inverse() @ frames[i][link.child]
            assert relative.distance_to(link.parent_from_child) < 1e-6
            assert relative.angle_to(link.parent_from_child) < 1e-5


def test_it_pauses_between_the_moves(played):
    _, script, frames = played
    hands = [moving_part(script, i) for i in range(1, len(frames))]
    assert hands[0] is None
    assert hands[-1] is None
    rests = [len(list(run)) for hand, run in itertools.groupby(hands) if hand is None]
    assert len(rests) >= len(plan_mounts(find_asset("hobby-corner-clamp")))
    assert min(rests) >= 8


def test_the_same_seed_gives_the_same_script(scene):
    asset = find_asset("hobby-corner-clamp")
    one, same, other = (timed_assembly(asset, scene, 400, seed) for seed in (3, 3, 4))
    for name, pose in one.poses_at(5.0).items():
        assert (pose.matrix == same.poses_at(5.0)[name].matrix).all()
    assert one.poses_at(0.0)["jaw"].distance_to(other.poses_at(0.0)["jaw"]) > 1e-3


def test_relative_poses_run_through_the_links_both_ways():
    asset = find_asset("hobby-corner-clamp")
    links = asset.states[-1].links
    from_base, from_bolt = joined("base", links), joined("bolt", links)
    assert from_base.keys() == from_bolt.keys() == {"base", "jaw", "bolt"}
    there_and_back = from_base["bolt"] @ from_bolt["base"]
    assert there_and_back.distance_to(Pose.identity()) < 1e-12
    assert joined("jaw", ()).keys() == {"jaw"}


def test_an_asset_without_steps_is_refused(scene):
    import dataclasses

    asset = dataclasses.replace(find_asset("hobby-corner-clamp"), steps=())
    with pytest.raises(WorkbenchError, match="no step"):
        timed_assembly(asset, scene, 100, 1)


def test_a_swing_begins_and_ends_where_it_should():
    start, goal = Pose.exp([0.3, 0, 0, 0, 0, 0.1]), Pose.exp([0, 1, 0, 0.2, 0.1, 0.2])
    up = np.array([0, 0, 0.1])
    swing = Swing(start, goal, up, up, Tremor.sampled(np.random.default_rng(0), 1.0))
    for share, pose in ((0, start), (1, goal)):
        assert swing.at(share).distance_to(pose) < 1e-9
        assert swing.at(share).angle_to(pose) < 1e-7
    ends_z = (start.translation[2] + goal.translation[2]) / 2
    assert swing.at(0.5).translation[2] > ends_z + 0.05


def test_a_twist_turns_about_a_line_beside_the_origin():
    twist = Twist(Pose.identity(), np.array([0, 0, 1.0]), math.pi, 0.0, 1, 0.0, (0.02, 0, 0))
    np.testing.assert_allclose(twist.at(0).transform(np.array([[0.02, 0, 0.5]])), [[0.02, 0, 0.5]])
    np.testing.assert_allclose(twist.at(0).translation, [0.04, 0, 0], atol=1e-9)
