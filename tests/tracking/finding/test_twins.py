"""Parts of one mesh: which is which, by where a link puts them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import DelayedLookout
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.finding.twins import twins_of
from snapfit.tracking.methods import create_tracker

ASSET = find_asset("hand-screw-clamp")
NAMES = ("jaw-1", "pad", "thread-1", "thread-2")
PARTS = tuple(part for part in ASSET.tracked_parts if part.name in NAMES)
LINKS = {link.child: link for link in ASSET.states[-1].links}


def at(rotation, *position_m) -> Pose:
    turned = Pose.exp([*rotation, 0, 0, 0]).rotation
    return Pose.from_rotation_translation(turned, np.array(position_m))


HERE = at([1.9, 0.2, 0.3], 0.0, 0.0, 0.45)
SLOT_1, SLOT_2 = (HERE @ LINKS[name].parent_from_child for name in ("thread-1", "thread-2"))
APART = at([0.4, 0.9, 0.2], 0.2, -0.03, 0.5)


@pytest.fixture
def twins():
    return twins_of(PARTS, load_bodies(PARTS), ASSET)


def said(found) -> list[tuple[str, str]]:
    """Names of the parts, and of their places."""
    places = {"slot 1": SLOT_1, "slot 2": SLOT_2, "apart": APART}
    return [
        (each.part, next(it for it in places if places[it] is each.camera_from_body))
        for each in found
    ]


def everywhere(*places: Pose) -> list[Hypothesis]:
    """Twins as a finder tells them: each at each place."""
    names = ("thread-2", "thread-1")
    return [Hypothesis(name, place, 0.9) for place in places for name in names]


def test_a_find_has_the_name_that_a_link_has_for_its_place(twins) -> None:
    missing, there = ["thread-1", "thread-2"], {"jaw-1": HERE}
    named = twins.named(everywhere(SLOT_1, SLOT_2), missing, there)
    assert said(named) == [("thread-1", "slot 1"), ("thread-2", "slot 2")]
    # Of one that no link has, nobody knows more than that it is the other one.
    named = twins.named(everywhere(APART, SLOT_1), missing, there)
    assert said(named) == [("thread-2", "apart"), ("thread-1", "slot 1")]


def test_without_what_carries_them_all_names_are_left(twins) -> None:
    found = everywhere(SLOT_1, APART)
    assert twins.named(found, ["thread-1", "thread-2"], {}) == found
    # One of them is known: there is nothing to choose.
    assert twins.named(found, ["thread-1"], {"jaw-1": HERE, "thread-2": APART}) == found


def test_one_in_the_other_s_place_is_the_other_one(twins) -> None:
    known = {"jaw-1": HERE, "thread-1": APART, "thread-2": SLOT_1}
    free = ["thread-1", "thread-2"]
    asked = [twins.exchanged(known, free) for _ in range(4)]
    assert asked[:2] == [{}, {}]  # it may only come by
    assert asked[2] == {"thread-1": SLOT_1, "thread-2": APART}
    assert asked[3] == {}


@pytest.mark.parametrize(
    ("known", "free"),
    [
        ({"thread-1": SLOT_1, "thread-2": APART}, ("thread-1", "thread-2")),
        ({"thread-1": APART, "thread-2": SLOT_2}, ("thread-1", "thread-2")),
        ({"thread-1": SLOT_1, "thread-2": SLOT_2}, ("thread-1", "thread-2")),
        ({"thread-1": APART, "thread-2": SLOT_1}, ("thread-1",)),
        ({"thread-2": SLOT_1}, ("thread-1", "thread-2")),
        ({"thread-1": APART, "thread-2": SLOT_1.perturbed([0, 0, 0, 0, 0, 0.02])}, ("thread-2",)),
    ],
    ids=["right", "before its turn", "both", "linked", "not seen", "near"],
)
def test_others_keep_their_names(twins, known, free) -> None:
    for _ in range(6):
        assert twins.exchanged({"jaw-1": HERE, **known}, free) == {}


def test_parts_that_all_differ_have_no_twins(clamp, bodies) -> None:
    assert twins_of(clamp, bodies, find_asset("hobby-corner-clamp")) is None
    assert twins_of(PARTS, load_bodies(PARTS), None) is None


class Nothing:
    """A finder that finds nothing."""

    names = NAMES

    def find(self, *_) -> list[Hypothesis]:
        return []


def test_a_step_that_is_done_with_the_other_twin_is_done(draw, camera) -> None:
    poses = {
        "jaw-1": HERE,
        "pad": HERE @ LINKS["pad"].parent_from_child,
        "thread-1": APART,
        "thread-2": SLOT_1,
    }
    tracker = create_tracker("gbot", PARTS, camera, asset=ASSET)
    twins = twins_of(PARTS, tracker.bodies, ASSET)
    finding = SelfStartingTracker(tracker, PARTS, DelayedLookout(Nothing(), 3), twins=twins)
    frame = draw(PARTS, poses)
    finding.start(frame, poses)
    finding.set_state("pad-on")
    for number in range(90):
        result = finding.track(replace(frame, name=str(number), captured_at_ns=number * 33_000_000))
    assert result.state == "first-thread-in"
    said = {each.part: each.camera_from_body for each in result.parts}
    assert said["thread-1"].distance_to(SLOT_1) < 0.01
    assert said["thread-2"].distance_to(APART) < 0.01
    assert np.isfinite(said["pad"].matrix).all()
