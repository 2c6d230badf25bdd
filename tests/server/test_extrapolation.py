"""`?at_us=`: poses at a time that is not the frame's."""

from __future__ import annotations

from typing import Any

import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.pose import Pose
from snapfit.server import quaternion
from snapfit.server.answers import SnapshotAnswers
from snapfit.server.extrapolation import LIMIT_S, extrapolated

vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3)
times = st.floats(-LIMIT_S, LIMIT_S)
COVARIANCE = np.diag([1e-4, 2e-4, 3e-4, 1e-6, 2e-6, 3e-6]).ravel().tolist()
CAPTURED_AT_US = 1_000_000_000


def part(turn: list[float], linear: list[float] | None, angular: list[float] | None) -> Any:
    return {
        "part": "jaw",
        "position": [0.1, 0.2, 0.7],
        "orientation": quaternion.exp(turn),
        "covariance": COVARIANCE,
        "linear_velocity": linear,
        "angular_velocity": angular,
    }


@given(vectors, vectors, vectors, times)
def test_a_part_goes_on_as_it_went(
    turn: list[float], linear: list[float], angular: list[float], ahead_s: float
) -> None:
    before = part(turn, linear, angular)
    after = extrapolated(before, ahead_s)
    moved = np.array(before["position"]) + ahead_s * np.array(linear)
    np.testing.assert_allclose(after["position"], moved, atol=1e-12)
    turned = Pose.exp([*(ahead_s * np.array(angular)), 0, 0, 0]).rotation
    start = Pose.from_quaternion(before["orientation"], [0, 0, 0]).rotation
    end = Pose.from_quaternion(after["orientation"], [0, 0, 0]).rotation
    np.testing.assert_allclose(end, turned @ start, atol=1e-9)


@given(st.floats(0.001, LIMIT_S / 2), st.sampled_from([-1, 1]))
def test_it_gets_the_less_certain_the_farther_it_is(ahead_s: float, direction: int) -> None:
    still = part([0, 0, 0], [0, 0, 0], [0, 0, 0])
    near = np.array(extrapolated(still, direction * ahead_s)["covariance"]).reshape(6, 6)
    far = np.array(extrapolated(still, 2 * direction * ahead_s)["covariance"]).reshape(6, 6)
    assert (np.diag(near) > np.diag(np.array(COVARIANCE).reshape(6, 6))).all()
    assert (np.diag(far) > np.diag(near)).all()
    assert np.linalg.eigvalsh(far).min() > 0


def test_without_velocities_it_stays_and_grows_less_certain() -> None:
    after = extrapolated(part([0.1, 0, 0], None, None), 0.05)
    assert after["position"] == [0.1, 0.2, 0.7]
    assert after["covariance"][0] > COVARIANCE[0]


def test_without_a_pose_there_is_none_later() -> None:
    lost = {**part([0, 0, 0], None, None), "position": None, "orientation": None}
    assert extrapolated(lost, 0.05) == lost


def answers() -> SnapshotAnswers:
    snapshot = {
        "boot_id": "b",
        "seq": 7,
        "captured_at_us": CAPTURED_AT_US,
        "parts": [part([0, 0, 0], [1.0, 0, 0], [0, 0, 0])],
    }
    return SnapshotAnswers(1, orjson.dumps(snapshot))


@pytest.mark.parametrize(
    ("ahead_us", "reached_us"),
    [(0, 0), (60_000, 60_000), (-60_000, -60_000), (100_000, 100_000), (250_000, 100_000),
     (-9_000_000, -100_000)],
)  # fmt: skip
def test_the_answer_tells_how_far_it_went(ahead_us: int, reached_us: int) -> None:
    answer = answers().all_parts(stale=False, at_us=CAPTURED_AT_US + ahead_us)
    body = orjson.loads(answer.body(CAPTURED_AT_US))
    assert body["at_us"] == CAPTURED_AT_US + reached_us
    assert body["at_clamped"] is (ahead_us != reached_us)
    assert body["parts"][0]["position"][0] == pytest.approx(0.1 + reached_us / 1e6)


def test_another_time_is_another_entity() -> None:
    them = answers()
    tags = {them.all_parts(stale=False, at_us=at).etag for at in (None, 1, 2)}
    tags |= {them.all_parts(stale=True, at_us=1).etag}
    assert len(tags) == 4
