"""The judge follows right sequences: every switch within 10 frames, none that is not there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from toy import BESIDE, ON_BOARD, carried, toy
from tracks import Noise, Track, judged, observed

from snapfit.models.pose import Pose
from snapfit.tracking.assembly.estimate import UNSEEN, AssemblyEstimate, Sighting
from snapfit.tracking.assembly.judge import StateJudge
from snapfit.tracking.assembly.parameters import GBOT_PAPER, AssemblyParameters
from snapfit.tracking.errors import TrackingError

USUAL = Noise(0.0015, math.radians(1.5))
EXACT = Noise(1e-6, 1e-6)


def states(estimates: list[AssemblyEstimate]) -> list[str]:
    found = [estimates[0].state]
    for estimate in estimates:
        if estimate.state != found[-1]:
            found.append(estimate.state)
    return found


def delays(track: Track, estimates: list[AssemblyEstimate]) -> list[int]:
    at = {e.changed.to_state: f for f, e in enumerate(estimates) if e.changed}
    return [at[track.states[switch]] - switch for switch in track.switches]


@pytest.mark.parametrize(("error_mm", "error_deg"), [(0.001, 0.001), (1, 1), (2, 2), (2.5, 3)])
def test_each_switch_of_a_right_sequence_is_found(
    track: Track, error_mm: float, error_deg: float
) -> None:
    noise = Noise(error_mm / 1e3, math.radians(error_deg))
    estimates = judged(track, noise, seed=1)
    assert states(estimates) == [track.states[0], *(track.states[f] for f in track.switches)]
    assert max(abs(delay) for delay in delays(track, estimates)) <= 10
    assert not [m for e in estimates for m in e.misassemblies]
    assert estimates[-1].finished_steps == tuple(step.name for step in track.asset.steps)
    assert estimates[-1].confidence > 0.8


def test_a_part_hidden_on_its_way_is_found_in_its_place(track: Track) -> None:
    """The part that is brought is out of sight from before its switch until after it."""
    moved = {}
    for f in track.switches:
        links = _new_children(track, f)
        moved |= {name: (name, f - 25, f + 6) for name in links}
    hidden = replace(USUAL, hidden=tuple(moved.values()))
    estimates = judged(track, hidden, seed=2)
    assert states(estimates) == [track.states[0], *(track.states[f] for f in track.switches)]
    assert max(abs(delay) for delay in delays(track, estimates)) <= 16
    assert not [m for e in estimates for m in e.misassemblies]


def _new_children(track: Track, switch: int) -> list[str]:
    graph = StateJudge(track.asset).graph
    edges = graph.edges(track.states[switch - 1])
    return [each.link.child for edge in edges for each in edge.deciding]


def test_the_paper_switches_as_soon_as_its_thresholds_are_met(track: Track) -> None:
    estimates = judged(track, USUAL, seed=1, parameters=GBOT_PAPER)
    ours = judged(track, USUAL, seed=1)
    assert states(estimates)[-1] == track.states[-1]
    assert np.mean(delays(track, estimates)) < np.mean(delays(track, ours))


def test_a_part_that_passes_by_switches_nothing() -> None:
    """Through the place, turned as it belongs, at 4 mm a frame."""
    place = ON_BOARD["left"].translation
    shift = np.array([0.15, 0, 0])
    here, there = place - shift, place + shift
    track = carried(toy(), [("left", Pose.from_translation(*here))])
    poses = list(track.poses)
    for share in np.linspace(0, 1, 76):
        pose = Pose.from_translation(*(here + share * (there - here)))
        poses.append({**poses[-1], "left": pose})
    passing = Track(track.asset, poses, ["free"] * len(poses))
    assert states(judged(passing, USUAL, seed=3)) == ["free"]
    assert states(judged(passing, USUAL, seed=3, parameters=GBOT_PAPER)) == ["free", "left-on"]


def test_either_way_leads_through_a_branch() -> None:
    asset = toy()
    for first, second in (("left", "right"), ("right", "left")):
        track = carried(asset, [(name, ON_BOARD[name]) for name in (first, second)])
        estimates = judged(track, USUAL, seed=4)
        assert states(estimates) == ["free", f"{first}-on", "both"]
        assert estimates[-1].finished_steps == (f"put-{first}", f"then-{second}")
        assert estimates[0].next_steps == ("put-left", "put-right")
        assert estimates[-1].next_steps == ()


def test_a_symmetric_part_is_in_place_either_way_round() -> None:
    turned = ON_BOARD["right"] @ Pose.exp([0, 0, math.pi, 0, 0, 0])
    estimates = judged(carried(toy(), [("right", turned)]), USUAL, seed=5)
    assert states(estimates) == ["free", "right-on"]
    change = next(e.changed for e in estimates if e.changed)
    assert change.fits[0].child_symmetry.angle_to(Pose.identity()) == pytest.approx(math.pi)


def test_a_part_taken_off_goes_back() -> None:
    ways = [("left", ON_BOARD["left"]), ("right", ON_BOARD["right"]), ("right", BESIDE["right"])]
    track = carried(toy(), [*ways, ("left", BESIDE["left"]), ("left", ON_BOARD["left"])])
    estimates = judged(track, USUAL, seed=6)
    assert states(estimates) == ["free", "left-on", "both", "left-on", "free", "left-on"]
    back = next(e.changed for e in estimates if e.changed and not e.changed.is_forward)
    assert back.steps == ("then-right",)
    assert back.to_state == "left-on"
    paper = judged(track, USUAL, seed=6, parameters=GBOT_PAPER)
    assert states(paper)[:3] == ["free", "left-on", "both"]
    assert states(paper)[-1] == "both"


def test_backwards_every_step_is_undone(track: Track) -> None:
    last = len(track.poses) - 1
    back = [*track.poses, *(track.poses[f] for f in range(last, -1, -1))]
    both = Track(track.asset, back, [*track.states, *reversed(track.states)])
    found = states(judged(both, USUAL, seed=7))
    there = [track.states[0], *(track.states[f] for f in track.switches)]
    assert found == [*there, *there[-2::-1]]


def test_an_operator_is_believed_against_the_evidence_of_the_moment() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"])], n_rest=150)
    judge = StateJudge(track.asset)
    hold = judge.parameters.hold_frames
    found = []
    for f, observations in enumerate(observed(track, USUAL, seed=8)):
        if f == 200:
            judge.set_state("free")
        found.append(judge.update(observations, f).state)
    assert found[199] == "left-on"
    assert set(found[200 : 200 + hold - 1]) == {"free"}
    assert found[200 + hold + 10] == "left-on"
    judge.set_state("both")
    for f, observations in enumerate(observed(track, USUAL, seed=9)[-hold + 1 :]):
        assert judge.update(observations, f).state == "both"
    with pytest.raises(TrackingError, match="no assembly state 'done'; there are: free, left-on"):
        judge.set_state("done")


def test_what_moves_after_an_operators_word_counts_at_once() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"])])
    judge = StateJudge(track.asset)
    judge.set_state("free")
    found = [judge.update(each, f).state for f, each in enumerate(observed(track, EXACT, 1))]
    assert found[-10] == "left-on"


def test_a_hidden_part_is_looked_for_in_its_place() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"])], n_rest=40)
    noise = replace(USUAL, hidden=(("left", 40, 999),))
    asked = []

    def probe(part: str, camera_from_body: Pose) -> Sighting:
        asked.append((part, camera_from_body.distance_to(ON_BOARD["left"])))
        return Sighting(0.9, camera_from_body) if len(asked) > 30 else UNSEEN

    def aside(part: str, camera_from_body: Pose) -> Sighting:
        return Sighting(0.9, camera_from_body @ Pose.from_translation(0, 0.01, 0))

    estimates = judged(track, noise, seed=10, probe=probe)
    assert states(estimates) == ["free", "left-on"]
    assert {part for part, _ in asked} == {"left"}
    assert max(distance for _, distance in asked) < 0.01
    assert states(judged(track, noise, seed=10)) == ["free"]
    assert states(judged(track, noise, seed=10, probe=lambda _, pose: Sighting(0.5, pose))) == [
        "free"
    ]
    assert states(judged(track, noise, seed=10, probe=aside)) == ["free"]


def test_a_part_that_is_tracked_at_a_wrong_place_is_looked_for_in_its_own() -> None:
    """The left block is put on the board, but its estimate stays behind, in doubt."""
    track = carried(toy(), [("left", ON_BOARD["left"])], n_rest=40)
    for is_sure, found in ((False, ["free", "left-on"]), (True, ["free"])):
        judge, estimates = StateJudge(track.asset), []
        for f, observations in enumerate(observed(track, USUAL, seed=12)):
            behind = [
                replace(each, camera_from_body=BESIDE["left"], is_sure=is_sure)
                if each.part == "left"
                else each
                for each in observations
            ]
            is_there = track.states[f] == "left-on"
            look = (lambda _, pose: Sighting(0.9, pose)) if is_there else (lambda *_: Sighting(0))
            estimates.append(judge.update(behind, f, look))
        assert states(estimates) == found
        if not is_sure:
            assert delays(track, estimates)[0] <= 10


def test_a_screw_that_the_image_shows_half_way_is_not_in_its_place() -> None:
    joint = {"type": "screw", "axis": (0, 0, 1), "pitch_m": 0.016, "travel_m": (-0.03, 0.03)}
    track = carried(toy(left={"joint": joint}), [("left", ON_BOARD["left"])], n_rest=40)
    noise = replace(USUAL, hidden=(("left", 40, 999),))
    for way_m, found in ((0.004, ["free"]), (0.0005, ["free", "left-on"])):
        turned = Pose.exp([0, 0, math.tau * way_m / 0.016, 0, 0, way_m])
        estimates = judged(
            track, noise, seed=13, probe=lambda _, pose, turned=turned: Sighting(0.9, pose @ turned)
        )
        assert states(estimates) == found


def test_a_step_that_nobody_sees_shows_when_the_next_is_done() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"]), ("right", ON_BOARD["right"])])
    asset = replace(track.asset, steps=(track.asset.steps[0], track.asset.steps[2]))
    asset = replace(asset, states=tuple(s for s in asset.states if s.name != "right-on"))
    hidden = replace(USUAL, hidden=(("left", 30, 999),))
    estimates = judged(replace(track, asset=asset), hidden, seed=11)
    assert states(estimates) == ["free", "both"]
    assert estimates[-1].finished_steps == ("put-left", "then-right")
    denied = judged(replace(track, asset=asset), hidden, seed=11, probe=lambda *_: Sighting(0.1))
    assert states(denied) == ["free"]


def test_a_part_left_elsewhere_in_its_joint_counts_after_a_while() -> None:
    joint = {"type": "prismatic", "axis": (0, 1, 0), "travel_m": (-0.03, 0.03)}
    asset = toy(left={"joint": joint})
    aside = ON_BOARD["left"] @ Pose.from_translation(0, 0.02, 0)
    track = carried(asset, [("left", aside)], n_rest=80)
    at = next(f for f, e in enumerate(judged(track, USUAL, seed=12)) if e.changed)
    assert 100 + 40 <= at <= 100 + 80 + 40


def test_confidence_falls_while_a_part_disagrees_with_its_link() -> None:
    track = carried(toy(), [("left", ON_BOARD["left"]), ("left", BESIDE["left"])])
    estimates = judged(track, EXACT, seed=13)
    back = next(f for f, e in enumerate(estimates) if e.changed and not e.changed.is_forward)
    settled, leaving = estimates[75].confidence, estimates[back - 1].confidence
    assert settled > 0.9
    assert leaving < 0.7


def test_an_asset_without_states_is_refused() -> None:
    with pytest.raises(TrackingError, match=r"'toy' has no assembly graph: add \[\[state\]\]"):
        StateJudge(replace(toy(), states=(), steps=()), AssemblyParameters())
