"""The scripted assembly: hand-like, smooth, without collisions, and with the right states."""

import itertools

import manifold3d
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.models.workbench.demo import Workbench
from snapfit.models.workbench.motion import Slide, Twist, minimum_jerk
from snapfit.models.workbench.script import Place, resting_pose

FRAME_S = 1 / 30


@pytest.fixture(scope="module")
def asset():
    return find_asset("hobby-corner-clamp")


@pytest.fixture(scope="module")
def script(asset):
    """That of the demo."""
    return Workbench(asset, 7).script


@pytest.fixture(scope="module")
def times_s(script):
    return np.arange(0, script.duration_s, FRAME_S)


@pytest.fixture(scope="module")
def frames(script, times_s):
    return [script.poses_at(t) for t in times_s]


def steps_of(frames, name):
    pairs = [(a[name], b[name]) for a, b in itertools.pairwise(frames)]
    moved_mm = np.array([a.distance_to(b) * 1000 for a, b in pairs])
    turned_deg = np.degrees([a.angle_to(b) for a, b in pairs])
    return moved_mm, turned_deg


def test_minimum_jerk_starts_and_ends_at_rest():
    share = np.linspace(0, 1, 1001)
    progress = np.array([minimum_jerk(s) for s in share])
    speed = np.gradient(progress, share)
    assert progress[0] == 0
    assert progress[-1] == 1
    assert (np.diff(progress) >= 0).all()
    assert speed[[0, -1]] == pytest.approx(0, abs=1e-4)
    assert speed.max() == pytest.approx(1.875, abs=1e-3)
    assert minimum_jerk(-1) == 0
    assert minimum_jerk(2) == 1


def test_a_twist_follows_the_pitch_and_rests_between_the_turns():
    goal = Pose.exp([0.3, 0.2, 0.1, 0.1, 0, 0.2])
    twist = Twist(goal, np.array([0.0, 0, 1]), turn_rad=4.0, pitch_m=0.01, n_twists=3)
    assert twist.at(1).distance_to(goal) < 1e-12
    held = 0
    for share in np.linspace(0, 1, 301):
        back = goal.inverse() @ twist.at(share)
        turn, travel = -back.log()[2], -back.translation[2]
        assert travel == pytest.approx(turn * 0.01 / (2 * np.pi), abs=1e-9) or turn < 0
        held += twist.at(share).distance_to(twist.at(share + 0.002)) < 1e-9
    assert held > 30
    assert twist.at(0).distance_to(goal) == pytest.approx(4.0 / (2 * np.pi) * 0.01)


def test_a_slide_does_not_turn():
    start = Pose.exp([0, 0, 1, 0, 0, 0])
    slide = Slide(start, start @ Pose.from_translation(0.03, 0, 0))
    assert slide.at(0.5).distance_to(start) == pytest.approx(0.015)
    assert slide.at(0.5).angle_to(start) < 1e-9


def test_a_part_lies_stably_on_the_bench(asset):
    for part in asset.parts:
        pose = resting_pose(part.mesh, Place(0.1, -0.2, 30, (0.1, -1, 0.05)))
        heights = pose.transform(part.mesh.vertices)[:, 2]
        assert heights.min() == pytest.approx(0, abs=1e-6)
        on_bench = pose.transform(part.mesh.vertices)[heights < 2e-5, :2]
        assert len(on_bench) >= 3
        np.testing.assert_allclose(pose.translation[:2], (0.1, -0.2))


def test_the_motion_is_smooth_and_neither_idle_nor_wild(frames, asset):
    for part in asset.parts:
        moved_mm, turned_deg = steps_of(frames, part.name)
        assert moved_mm.max() < 8, part.name
        assert turned_deg.max() < 9, part.name
        assert np.abs(np.diff(moved_mm)).max() < 1.5, part.name
    carried = np.concatenate([steps_of(frames, p.name)[0] for p in asset.parts])
    assert 2 <= np.median(carried[carried > 0.5]) <= 4


def test_only_one_thing_moves_at_a_time(script, frames, times_s, asset):
    moved = set()
    for (before, now), (a_s, b_s) in zip(
        itertools.pairwise(frames), itertools.pairwise(times_s), strict=True
    ):
        parts = {name for name, pose in now.items() if before[name].distance_to(pose) > 1e-6}
        assert any(parts <= set(script.moving_at(at_s)) for at_s in (a_s, b_s))
        moved |= parts
    assert moved == {part.name for part in asset.parts}


def test_it_rests_at_both_ends(script, frames):
    for name in script.initial:
        moved_mm, _ = steps_of(frames, name)
        assert moved_mm[:22].max() == 0
        assert moved_mm[-20:].max() == 0
    assert script.rest_at(0.5) == 0
    assert script.rest_at(script.duration_s) == len(script.moves)
    first = script.moves[0]
    assert script.rest_at(first.start_s + 0.1) is None
    assert script.moving_at(0) == (first.part, *sorted(first.carried))


def test_no_part_goes_through_the_bench_or_another_part(asset, frames):
    solids = {
        part.name: manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        for part in asset.parts
    }
    for poses in frames[::3]:
        placed = {}
        for name, pose in poses.items():
            matrix = pose.matrix[:3].copy()
            matrix[:, 3] *= 1000
            placed[name] = solids[name].transform(matrix)
            assert placed[name].bounding_box()[2] > -0.05
        for one, other in itertools.combinations(placed.values(), 2):
            # Threads touch while a screw is pushed to where it bites.
            assert (one ^ other).volume() < 0.003 * min(one.volume(), other.volume())


def test_the_state_changes_when_a_part_has_reached_its_place(asset, script, frames, times_s):
    names = [script.state_at(t) for t in times_s]
    assert names[0] == "parts-free"
    assert names[-1] == "assembled"
    for state in asset.states[1:]:
        first = names.index(state.name)
        link = state.links[-1]
        for i, is_there in ((first, True), (first - 1, False)):
            relative = frames[i][link.parent].inverse() @ frames[i][link.child]
            assert (relative.distance_to(link.parent_from_child) < 1e-9) == is_there, (state, i)


def test_a_slowed_script_goes_the_same_ways_in_more_time(script):
    slow = script.slowed(2.0)
    assert slow.duration_s == 2 * script.duration_s
    for time_s in (0.0, 2.2, 5.1, script.duration_s):
        assert slow.state_at(2 * time_s) == script.state_at(time_s)
        assert slow.moving_at(2 * time_s) == script.moving_at(time_s)
        for name, pose in slow.poses_at(2 * time_s).items():
            assert pose.distance_to(script.poses_at(time_s)[name]) < 1e-9
