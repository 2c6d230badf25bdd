"""Turns that nobody can see are no motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from toy import BESIDE, ON_BOARD, carried, toy
from tracks import Noise, Track, judged

from snapfit.models.asset import Asset
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry, SymmetryAxis
from snapfit.tracking.assembly.unseen_turns import UnseenTurns

AXIS = SymmetryAxis(np.array([0.0, 0.6, 0.8]), np.array([0.01, -0.02, 0.03]))
POSE = Pose.exp([0.4, -0.2, 0.9, 0.1, 0.05, 0.6])
USUAL = Noise(0.0015, math.radians(1.5))


@pytest.fixture
def turns() -> UnseenTurns:
    return UnseenTurns({"knob": Symmetry(axis=AXIS), "jaw": Symmetry()})


def test_a_turn_about_the_axis_of_symmetry_is_taken_out(turns: UnseenTurns) -> None:
    for angle in (0.0, 0.5, 1.5, -2.0):
        told = turns.taken_out({"knob": POSE @ AXIS.turn(angle), "jaw": POSE}, joined=())
        assert told["knob"].distance_to(POSE) < 1e-9
        assert told["knob"].angle_to(POSE) < 1e-6
        assert told["jaw"] is POSE


def test_what_can_be_seen_of_a_motion_stays(turns: UnseenTurns) -> None:
    turns.taken_out({"knob": POSE}, joined=())
    moved = Pose.exp([0.3, 0.1, -0.2, 0.02, 0.01, 0.03]) @ POSE
    told = turns.taken_out({"knob": moved @ AXIS.turn(2.0)}, joined=())["knob"]
    on_axis = np.array([AXIS.point_m, AXIS.point_m + 0.1 * AXIS.direction])
    assert told.transform(on_axis) == pytest.approx(moved.transform(on_axis), abs=1e-9)
    assert told.angle_to(POSE) <= moved.angle_to(POSE) + 1e-9


def test_the_turn_of_a_joined_part_counts(turns: UnseenTurns) -> None:
    turns.taken_out({"knob": POSE}, joined=())
    assert turns.forget(["knob", "jaw"]) == ("knob",)
    turned = POSE @ AXIS.turn(1.0)
    assert turns.taken_out({"knob": turned}, joined=["knob"])["knob"] is turned
    assert turns.forget(["knob"]) == ()


def spinning(asset: Asset, track: Track, part: str, first: int, last: int = 999) -> Track:
    """A track in which the estimate of a part turns unseen, 4 degrees a frame."""
    axis = next(each.symmetry.axis for each in asset.parts if each.name == part)
    assert axis is not None
    turned = [
        {
            **poses,
            part: poses[part] @ axis.turn(math.radians(4) * (np.clip(f, first, last) - first)),
        }
        for f, poses in enumerate(track.poses)
    ]
    return Track(track.asset, turned, track.states)


def round_left() -> Asset:
    asset = toy()
    upright = Symmetry(axis=SymmetryAxis(np.array([0.0, 0.0, 1.0]), np.zeros(3)))
    parts = [replace(p, symmetry=upright) if p.name == "left" else p for p in asset.parts]
    return replace(asset, parts=tuple(parts))


def test_a_wrong_part_is_found_though_its_estimate_turns_about_its_axis() -> None:
    asset = round_left()
    wrong = carried(asset, [("left", Pose.from_translation(0, 0, 0.02))], n_rest=60)
    estimates = judged(spinning(asset, wrong, "left", 60), USUAL, seed=4)
    assert {m.part for each in estimates[-5:] for m in each.misassemblies} == {"left"}


def test_a_turn_that_nobody_sees_is_no_move() -> None:
    """The left block lies on the board from the start; only its estimate turns."""
    asset = round_left()
    start = {**BESIDE, "left": Pose.from_translation(0, 0, 0.02)}
    lying = Track(asset, [start] * 30, ["free"] * 30)
    way = carried(asset, [("right", ON_BOARD["right"])], n_rest=60)
    poses = [*lying.poses, *({**each, "left": start["left"]} for each in way.poses)]
    track = Track(asset, poses, ["free"] * 30 + list(way.states))
    estimates = judged(spinning(asset, track, "left", 0, 60), USUAL, seed=5)
    assert estimates[-1].state == "right-on"
    assert not [m for each in estimates for m in each.misassemblies]
