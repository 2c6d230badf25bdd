"""From a result to a snapshot: all fields, velocities, and nothing that is not finite."""

from __future__ import annotations

import time

import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.pose import Pose
from snapfit.server.clock import Clock
from snapfit.server.schemas import PartPose, PoseSnapshot
from snapfit.server.snapshot import SnapshotWriter
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

SECOND_NS = 1_000_000_000
CLOCK = Clock.started_now()


def writer() -> SnapshotWriter:
    return SnapshotWriter(station="bench", asset="clamp", boot_id="boot", clock=CLOCK)


def snapshot(to: SnapshotWriter, *estimates: PartEstimate, at_ns: int = SECOND_NS) -> PoseSnapshot:
    payload = to.write(TrackingResult("1", at_ns, estimates, 1.0))
    return PoseSnapshot.model_validate({**orjson.loads(payload), "age_us": 0})


def tracked(pose: Pose, confidence: float = 0.9, **more: object) -> PartEstimate:
    return PartEstimate("jaw", Status.TRACKED, confidence, pose, **more)  # type: ignore[arg-type]


def only_part(of: PoseSnapshot) -> PartPose:
    (part,) = of.parts
    return part


def test_every_field_is_said() -> None:
    pose = Pose.exp([0.1, -0.2, 0.3, 0.01, 0.02, 0.7])
    covariance = np.arange(36, dtype=np.float64).reshape(6, 6)
    before_us = CLOCK.now_us()
    got = snapshot(writer(), tracked(pose, covariance=covariance))
    assert (got.station, got.asset, got.boot_id, got.seq) == ("bench", "clamp", "boot", 1)
    assert (got.frame, got.convention, got.stale) == ("camera", "opencv", False)
    assert got.captured_at_us == 1_000_000
    assert before_us <= got.published_at_us <= CLOCK.now_us()
    part = only_part(got)
    assert (part.part, part.status, part.confidence) == ("jaw", "tracked", 0.9)
    np.testing.assert_allclose(part.position or [], pose.translation, rtol=1e-6)
    np.testing.assert_allclose(part.orientation or [], pose.quaternion, rtol=1e-6)
    assert part.covariance == list(range(36))
    assert part.linear_velocity is None
    assert part.last_seen_at_us == 1_000_000


def test_seq_grows_by_one() -> None:
    to = writer()
    assert [snapshot(to).seq for _ in range(3)] == [1, 2, 3]


vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3)


@given(vectors, vectors, vectors)
def test_velocities_are_finite_differences_in_the_camera_frame(
    start_rad: list[float], linear: list[float], angular: list[float]
) -> None:
    period_s = 0.05
    first = Pose.exp([*start_rad, 0.1, 0.2, 0.7])
    turn = Pose.exp([*(np.array(angular) * period_s), 0, 0, 0])
    second = Pose.from_rotation_translation(
        turn.rotation @ first.rotation, first.translation + np.array(linear) * period_s
    )
    to = writer()
    snapshot(to, tracked(first))
    part = only_part(snapshot(to, tracked(second), at_ns=SECOND_NS + round(period_s * 1e9)))
    np.testing.assert_allclose(part.linear_velocity or [], linear, atol=1e-6)
    np.testing.assert_allclose(part.angular_velocity or [], angular, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "has_velocities"),
    [
        ([0, 0, 0, 0.1, 0, 0], True),
        ([0, 0, 0, 0.2, 0, 0], False),
        ([0, 0.9, 0, 0, 0, 0], True),
        ([0, 1.1, 0, 0, 0, 0], False),
    ],
    ids=["3 m/s", "6 m/s", "27 rad/s", "33 rad/s"],
)
def test_a_jump_is_no_motion(change: list[float], has_velocities: bool) -> None:
    to, frame_ns = writer(), SECOND_NS // 30
    pose = Pose.exp([0.1, -0.2, 0.3, 0.01, 0.02, 0.7])
    snapshot(to, tracked(pose))
    part = only_part(snapshot(to, tracked(pose.perturbed(change)), at_ns=SECOND_NS + frame_ns))
    assert (part.linear_velocity is not None) == has_velocities
    assert (part.angular_velocity is not None) == has_velocities


def test_after_a_gap_there_is_no_velocity_and_last_seen_is_kept() -> None:
    to = writer()
    snapshot(to, tracked(Pose.identity()))
    lost = only_part(snapshot(to, PartEstimate("jaw", Status.LOST, 0.0, None), at_ns=2 * SECOND_NS))
    assert lost.last_seen_at_us == 1_000_000
    found = only_part(snapshot(to, tracked(Pose.identity()), at_ns=3 * SECOND_NS))
    assert found.linear_velocity is None
    assert found.last_seen_at_us == 3_000_000


def test_a_predicted_part_is_not_seen() -> None:
    estimate = PartEstimate("jaw", Status.PREDICTED, 0.4, Pose.identity())
    assert only_part(snapshot(writer(), estimate)).last_seen_at_us is None


@pytest.mark.parametrize("status", [Status.LOST, Status.SEARCHING])
def test_without_a_pose_nothing_is_said_of_it(status: Status) -> None:
    estimate = PartEstimate("jaw", status, 0.1, Pose.identity(), np.eye(6))
    part = only_part(snapshot(writer(), estimate))
    assert part.status == status
    assert (part.position, part.orientation, part.covariance) == (None, None, None)


def broken(value: float) -> Pose:
    pose = Pose.identity()
    object.__setattr__(pose, "matrix", np.full((4, 4), value))
    return pose


@pytest.mark.parametrize(
    "estimate",
    [
        tracked(broken(np.nan)),
        tracked(broken(np.inf)),
        tracked(Pose.identity(), confidence=np.nan),
        PartEstimate("jaw", Status.TRACKED, 0.9, None),
    ],
    ids=["nan pose", "infinite pose", "nan confidence", "no pose"],
)
def test_what_is_not_finite_is_published_as_lost(estimate: PartEstimate) -> None:
    part = only_part(snapshot(writer(), estimate))
    assert part.status == "lost"
    assert (part.position, part.orientation, part.last_seen_at_us) == (None, None, None)


def test_a_covariance_that_is_not_finite_is_not_said() -> None:
    estimate = tracked(Pose.identity(), covariance=np.full((6, 6), np.inf))
    part = only_part(snapshot(writer(), estimate))
    assert part.status == "tracked"
    assert part.covariance is None


def test_the_clock_never_follows_a_jump_of_the_wall_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock.started_now()
    begin_ns = time.monotonic_ns()
    before_us = clock.now_us()
    monkeypatch.setattr("time.time_ns", lambda: 0)
    passed_us = clock.now_us() - before_us
    assert 0 <= passed_us <= (time.monotonic_ns() - begin_ns) / 1000 + 1
