"""Wrong sequences are noticed and named, right ones and harmless rests are not."""

from __future__ import annotations

import copy
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from toy import BESIDE, ON_BOARD, carried, toy
from tracks import Noise, Track, judged, observed
from wrong_tracks import WrongTrack, WrongTracks

from snapfit.models.pose import Pose
from snapfit.tracking.assembly.contact import Contacts
from snapfit.tracking.assembly.estimate import Misassembly, MisassemblyKind
from snapfit.tracking.assembly.judge import StateJudge

USUAL = Noise(0.0015, math.radians(1.5))


def events(track: Track, noise: Noise = USUAL, seed: int = 1) -> list[tuple[int, Misassembly]]:
    estimates = judged(track, noise, seed)
    return [(f, event) for f, each in enumerate(estimates) for event in each.misassemblies]


class Rehearsal:
    """A judge at every frame of a right sequence, to be taken up from there."""

    def __init__(self, track: Track, frames: set[int]) -> None:
        judge = StateJudge(track.asset)
        self._track = track
        self._judges = {}
        for f, observations in enumerate(observed(track, USUAL, seed=3)):
            judge.update(observations, f)
            if f in frames:
                kept = [judge.graph, judge._watch._contacts, judge.parameters]
                self._judges[f] = copy.deepcopy(judge, {id(each): each for each in kept})

    def goes_wrong(self, wrong: WrongTrack, seed: int) -> list[tuple[int, Misassembly]]:
        """Events of the frames after the right ones."""
        begin = wrong.begin
        judge = self._judges[begin]
        kept = [judge.graph, judge._watch._contacts, judge.parameters]
        judge = copy.deepcopy(judge, {id(each): each for each in kept})
        rest = Track(
            wrong.track.asset, wrong.track.poses[begin + 1 :], wrong.track.states[begin + 1 :]
        )
        found = []
        for f, observations in enumerate(observed(rest, USUAL, seed), start=begin + 1):
            estimate = judge.update(observations, f)
            found += [(f, event) for event in estimate.misassemblies]
        assert judge.state == wrong.track.states[-1]
        return found


def test_wrong_sequences_are_found_and_named(track: Track) -> None:
    """At least 95 % in each asset; 68 cases over the five."""
    wrongs = list(WrongTracks(track, seed=0).all())
    rehearsal = Rehearsal(track, {wrong.begin for wrong in wrongs})
    count: Counter[str] = Counter()
    for i, wrong in enumerate(wrongs):
        found = rehearsal.goes_wrong(wrong, seed=i)
        of_part = [(f, event) for f, event in found if event.part == wrong.part]
        assert len(of_part) == len(found), (wrong.kind, wrong.part, found[0][1])
        count["all"] += 1
        count["found"] += any(f <= wrong.rests_from + 40 for f, _ in of_part)
        count["named"] += bool(of_part) and of_part[-1][1].kind is wrong.kind
        assert all(f > wrong.rests_from for f, _ in of_part)
    assert count["all"] >= 5
    assert count["found"] >= 0.95 * count["all"]
    assert count["named"] >= 0.8 * count["all"]


@pytest.mark.parametrize(
    ("part", "goal", "kind"),
    [
        ("left", Pose.from_translation(0, 0, 0.0205), MisassemblyKind.WRONG_PLACE),
        (
            "left",
            Pose.from_translation(-0.05, 0, 0.025) @ Pose.exp([1.5708, 0, 0, 0, 0, 0]),
            MisassemblyKind.WRONG_WAY_ROUND,
        ),
        ("right", ON_BOARD["left"], MisassemblyKind.WRONG_PART),
    ],
)
def test_a_wrong_part_is_put_right(part: str, goal: Pose, kind: MisassemblyKind) -> None:
    track = carried(toy(), [(part, goal), (part, ON_BOARD[part])], n_rest=50)
    found = events(track)
    assert {(event.part, event.parent, event.kind) for _, event in found} == {(part, "board", kind)}
    frames = [f for f, _ in found]
    assert 90 + 15 <= frames[0] <= 90 + 40
    assert frames[-1] < 140 + 25
    assert abs(found[0][1].since_frame - 90) < 8
    assert found[0][1].translation_m > 0.004 or found[0][1].rotation_rad > 1


def test_a_later_link_before_its_time_is_the_wrong_order() -> None:
    asset = toy()
    chain = [asset.steps[0], asset.steps[2]]
    states = [state for state in asset.states if state.name != "right-on"]
    asset = replace(asset, steps=tuple(chain), states=tuple(states))
    found = events(carried(asset, [("right", ON_BOARD["right"])], n_rest=50))
    assert {(event.part, event.kind) for _, event in found} == {
        ("right", MisassemblyKind.WRONG_ORDER)
    }


def test_rests_that_are_harmless() -> None:
    beside = Pose.from_translation(-0.13, 0.02, 0.01)
    in_the_air = Pose.from_translation(0.05, 0, 0.06)
    for ways in (
        [("left", beside)],
        [("right", in_the_air)],
        [("left", in_the_air), ("left", BESIDE["left"])],
    ):
        assert events(carried(toy(), ways, n_rest=60)) == []


def test_what_touches_from_the_start_was_not_put_there() -> None:
    start = {**BESIDE, "left": Pose.from_translation(-0.02, 0, 0.02)}
    track = Track(toy(), [start] * 120, ["free"] * 120)
    assert events(track) == []


def test_a_part_that_is_only_predicted_is_not_judged() -> None:
    track = carried(toy(), [("left", Pose.from_translation(0, 0, 0.02))], n_rest=60)
    hidden = Noise(USUAL.way_m, USUAL.turn_rad, (("left", 45, 999),))
    assert events(track, hidden) == []


def doubted(track: Track, part: str, frames: range, seed: int = 1) -> list[set[str]]:
    """Parts that are told to be wrong, by frame, while one is tracked but in doubt."""
    judge, told = StateJudge(track.asset), []
    for f, observations in enumerate(observed(track, USUAL, seed)):
        seen = [
            replace(each, is_sure=False) if each.part == part and f in frames else each
            for each in observations
        ]
        told.append({event.part for event in judge.update(seen, f).misassemblies})
    return told


def test_a_part_in_doubt_is_not_told_to_be_wrong_before_it_is_seen_well() -> None:
    track = carried(toy(), [("left", Pose.from_translation(0, 0, 0.02))], n_rest=120)
    told = doubted(track, "left", range(150))
    assert not any(told[:150])
    assert told[-1] == {"left"}


def test_no_order_is_wrong_while_nobody_sees_whether_the_step_before_is_done() -> None:
    asset = toy()
    states = tuple(state for state in asset.states if state.name != "right-on")
    asset = replace(asset, steps=(asset.steps[0], asset.steps[2]), states=states)
    aside = Pose.from_translation(-0.1, -0.12, 0.02)
    track = carried(asset, [("left", aside), ("right", ON_BOARD["right"])], n_rest=60)
    assert doubted(track, "left", range(0))[-1] == {"right"}
    assert not any(doubted(track, "left", range(60, 999)))


def test_two_free_parts_that_touch_are_nobodys_business() -> None:
    on_right = BESIDE["right"] @ Pose.from_translation(0, 0, 0.02)
    assert events(carried(toy(), [("left", on_right)], n_rest=60)) == []


def test_gaps_between_surfaces() -> None:
    contacts = Contacts(toy().parts)
    for gap_m in (0.0, 0.002, 0.01):
        pose = Pose.from_translation(0.02, 0, 0.02 + gap_m).matrix
        found_m = contacts.gap_m("board", "left", pose, 0.05)
        assert gap_m - 1e-6 <= found_m < gap_m + 0.0015
    assert contacts.gap_m("board", "left", Pose.from_translation(0, 0, 1).matrix, 0.05) == math.inf
    assert contacts.diameter_m["left"] == pytest.approx(
        np.linalg.norm([0.04, 0.03, 0.02]), rel=1e-3
    )


def test_more_noise_finds_nothing_in_a_right_sequence() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"]), ("right", ON_BOARD["right"])], n_rest=60)
    for seed in range(5):
        assert events(track, Noise(0.003, math.radians(3)), seed) == []
