"""What happens at a bench: parts come and go, the camera is covered, somebody knocks the table.

Each test plays drawn frames of the bench, one after the other, to a tracker that was never told a
pose. It looks with a stand-in, which gives true poses that are some millimetres and degrees off a
few frames late, and in the slow tests with the geometric finder, a second late.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest
from bench import NORMAL, Shot, play

from snapfit.models.pose import Pose
from snapfit.tracking.result import Status

SETTLED = 36
"""Frames until whoever finds the parts has found them."""

METHODS = ["gbot", "icg"]
DETECTORS = ["stand-in", pytest.param("geometric", marks=pytest.mark.slow)]
pytestmark = [
    pytest.mark.parametrize("method", METHODS),
    pytest.mark.parametrize("detector", DETECTORS),
]
# Of frames, from when all can be seen again: the detector's delay twice, and what it takes to
# notice that a part is lost.
BACK_WITHIN = {"stand-in": 16, "geometric": 72}


@pytest.fixture(autouse=True)
def _needs_open3d(detector: str, request: pytest.FixtureRequest) -> None:
    if detector == "geometric":
        request.getfixturevalue("needs_open3d")


def knocked(poses: dict[str, Pose], names: Collection[str] | None = None) -> dict[str, Pose]:
    """Parts pushed by 8 cm along the bench and turned by 25 degrees, each about itself."""
    turn = Pose.exp([*(np.radians(25) * NORMAL), 0, 0, 0]).rotation
    along = np.cross(NORMAL, [1.0, 0.0, 0.0])
    push_m = 0.08 * (0.6 * np.array([1.0, 0.0, 0.0]) + 0.8 * along)
    pushed = {
        name: Pose.from_rotation_translation(turn @ pose.rotation, pose.translation + push_m)
        for name, pose in poses.items()
    }
    return {**poses, **{name: pushed[name] for name in names or poses}}


def test_a_cold_start(method, detector, clamp, lying, draw) -> None:
    shots = [Shot(draw(clamp, lying), lying, SETTLED)]
    played = play(method, detector, shots)
    assert {each.status for each in played[0].result.parts} == {Status.SEARCHING}
    assert all(each.camera_from_body is None for each in played[0].result.parts)
    assert played[-1].are_right(lying)


def test_a_part_that_leaves_is_found_where_it_comes_back(
    method, detector, clamp, lying, draw
) -> None:
    others = {name: pose for name, pose in lying.items() if name != "jaw"}
    elsewhere = knocked(lying, ["jaw"])
    away = 40
    shots = [
        Shot(draw(clamp, lying), lying, SETTLED),
        Shot(draw(clamp, others), others, away),
        Shot(draw(clamp, elsewhere), elsewhere, BACK_WITHIN[detector]),
    ]
    played = play(method, detector, shots)
    assert played[SETTLED - 1].are_right(lying)
    for each in played[SETTLED + 10 : SETTLED + away]:
        assert each.are_right(others)
        assert each.part("jaw").status is not Status.TRACKED
    assert played[SETTLED + away - 1].part("jaw").confidence < 0.5
    assert played[-1].are_right(elsewhere)


def test_after_the_camera_was_covered(method, detector, clamp, lying, draw) -> None:
    frame = draw(clamp, lying)
    black = replace(frame, color=np.zeros_like(frame.color), depth=np.zeros_like(frame.depth))
    covered = 60
    shots = [
        Shot(frame, lying, SETTLED),
        Shot(black, {}, covered),
        Shot(frame, lying, 5),
    ]
    played = play(method, detector, shots)
    for each in played[SETTLED : SETTLED + covered]:
        for part in each.result.parts:
            assert part.status is not Status.TRACKED or part.confidence < 0.5
    assert played[-1].are_right(lying)


@pytest.mark.parametrize("names", [None, ["jaw"]], ids=["everything", "one part"])
def test_after_the_bench_was_knocked(method, detector, names, clamp, lying, draw) -> None:
    after = knocked(lying, names)
    shots = [
        Shot(draw(clamp, lying), lying, SETTLED),
        Shot(draw(clamp, after), after, BACK_WITHIN[detector]),
    ]
    played = play(method, detector, shots)
    assert played[SETTLED - 1].are_right(lying)
    assert played[-1].are_right(after)
    if names is not None:
        others = {name: pose for name, pose in after.items() if name not in names}
        assert all(each.are_right(others) for each in played[SETTLED:])


def test_covered_for_so_long_that_all_is_given_up_and_knocked_meanwhile(
    method, detector, clamp, lying, draw
) -> None:
    frame, after = draw(clamp, lying), knocked(lying)
    black = replace(frame, color=np.zeros_like(frame.color), depth=np.zeros_like(frame.depth))
    shots = [
        Shot(frame, lying, SETTLED),
        Shot(black, {}, 180),
        Shot(draw(clamp, after), after, BACK_WITHIN[detector]),
    ]
    played = play(method, detector, shots)
    assert {each.status for each in played[SETTLED + 179].result.parts} == {Status.LOST}
    assert played[-1].are_right(after)
