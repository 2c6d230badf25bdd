"""Which parts are looked for, and when a find is believed."""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.tracking.optimiser import Attempt
from snapfit.tracking.recovery import recovery as module
from snapfit.tracking.recovery.recovery import Recovery
from snapfit.tracking.result import PartEstimate, Status

HOME = Pose.from_translation(0.0, 0.0, 0.6)
ELSEWHERE = Pose.from_translation(0.1, 0.0, 0.6)


class FakeRegainer:
    """Notes what it is asked for; finds what it is told to find."""

    def __init__(self, *_: Any) -> None:
        self.wanted: list[Mapping[int, Any]] = []
        self.found: dict[int, Attempt] = {}

    def search(self, frame: Any, wanted: Mapping[int, Any], known: Sequence[int]) -> Any:
        del frame, known
        self.wanted.append(dict(wanted))
        return {body: found for body, found in self.found.items() if body in wanted}


class FakeCarried:
    def __init__(self, *_: Any) -> None:
        pass

    def follow(self, *_: Any) -> dict[int, Pose]:
        return {}


class FakeOptimiser:
    """One free body."""

    def __init__(self) -> None:
        self.structures = SimpleNamespace(members=lambda body: np.array([body]))
        self.likelihoods = np.array([100.0])
        self.moved: list[Pose] = []

    def pose(self, body: int) -> Pose:
        del body
        return HOME

    def carry_back(self, body: int, pose: Pose) -> None:
        del body
        self.moved.append(pose)


@pytest.fixture
def optimiser() -> FakeOptimiser:
    return FakeOptimiser()


@pytest.fixture
def recovery(monkeypatch: pytest.MonkeyPatch, optimiser: FakeOptimiser) -> Recovery:
    monkeypatch.setattr(module, "Regainer", FakeRegainer)
    monkeypatch.setattr(module, "CarriedParts", FakeCarried)
    judge = SimpleNamespace(usual=lambda _: 0.9, reset=lambda _: None)
    return Recovery([SimpleNamespace()], None, optimiser, judge, None)  # type: ignore[list-item, arg-type]


def follow(recovery: Recovery, status: Status, confidence: float) -> list[int]:
    estimate = PartEstimate("jaw", status, confidence, HOME)
    return recovery.follow(None, [estimate])  # type: ignore[arg-type]


def wanted_last(recovery: Recovery) -> Mapping[int, Any]:
    return recovery._regainer.wanted[-1]  # type: ignore[attr-defined, no-any-return]


def tried(likelihood: float) -> Attempt:
    return Attempt(ELSEWHERE, likelihood, None, True)  # type: ignore[arg-type]


def test_what_agrees_as_usual_is_not_looked_for(recovery: Recovery) -> None:
    follow(recovery, Status.TRACKED, 0.85)
    assert wanted_last(recovery) == {}


@pytest.mark.parametrize(
    ("status", "confidence"),
    [(Status.TRACKED, 0.6), (Status.PREDICTED, 0.0), (Status.LOST, 0.0)],
)
def test_what_agrees_much_less_than_usual_is_looked_for(
    recovery: Recovery, status: Status, confidence: float
) -> None:
    follow(recovery, Status.TRACKED, 0.85)
    follow(recovery, status, confidence)
    assert list(wanted_last(recovery)) == [0]


def test_what_was_never_seen_is_not_looked_for_but_proposals_are_tried(recovery: Recovery) -> None:
    follow(recovery, Status.LOST, 0.0)
    assert wanted_last(recovery) == {}
    recovery.propose({0: [ELSEWHERE]})
    follow(recovery, Status.LOST, 0.0)
    assert wanted_last(recovery)[0].proposed == (ELSEWHERE,)
    assert not wanted_last(recovery)[0].is_searched


@pytest.mark.parametrize(("likelihood", "goes"), [(120.0, False), (200.0, True)])
def test_a_tracked_part_goes_only_where_more_is_explained(
    recovery: Recovery, optimiser: FakeOptimiser, likelihood: float, goes: bool
) -> None:
    recovery._regainer.found = {0: tried(likelihood)}  # type: ignore[attr-defined]
    recovery.propose({0: [ELSEWHERE]})
    assert follow(recovery, Status.TRACKED, 0.85) == ([0] if goes else [])
    assert optimiser.moved == ([ELSEWHERE] if goes else [])


def test_what_was_found_is_looked_for_a_while_still(recovery: Recovery) -> None:
    follow(recovery, Status.TRACKED, 0.85)
    recovery._regainer.found = {0: tried(50.0)}  # type: ignore[attr-defined]
    assert follow(recovery, Status.LOST, 0.0) == [0]
    recovery._regainer.found = {}  # type: ignore[attr-defined]
    searched = []
    for _ in range(60):
        follow(recovery, Status.TRACKED, 0.85)
        searched.append(bool(wanted_last(recovery)))
    assert searched[0]
    assert not searched[-1]
