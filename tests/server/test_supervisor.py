"""When a worker is started again, and when not."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from typing import cast

import pytest
from harness import is_alive, wait_for, with_tests

from snapfit.server.clock import Clock
from snapfit.server.pose_store import PoseStore
from snapfit.server.schemas import Phase, WorkerReport
from snapfit.server.supervisor import RestartPolicy, Supervisor, describe_exit
from snapfit.server.worker_spec import WorkerSpec


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[PoseStore]:
    monkeypatch.setenv("PYTHONPATH", with_tests())
    it = PoseStore.create()
    yield it
    it.close()


def supervisor(store: PoseStore, policy: RestartPolicy) -> Supervisor:
    spec = WorkerSpec(
        station="bench",
        source="demo",
        asset=None,
        method="icg",
        boot_id="",
        wall_minus_monotonic_ns=Clock.started_now().wall_minus_monotonic_ns,
        poses_segment=store.names.poses,
        pictures_segment=store.names.pictures,
        pipeline="scripted_pipeline:open_pipeline",
    )
    return Supervisor(spec, store, policy)


def test_delays_grow_up_to_a_limit() -> None:
    policy = RestartPolicy(first_delay_s=0.5, longest_delay_s=3.0)
    assert [policy.delay_s(failed) for failed in range(6)] == [0, 0.5, 1, 2, 3, 3]


def test_ends_are_told_apart() -> None:
    assert describe_exit(-9) == "was killed by SIGKILL"
    assert describe_exit(0) == "ended by itself"
    assert describe_exit(1) == "failed with exit code 1"


def test_a_worker_that_hangs_is_killed_and_started_again(
    store: PoseStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCRIPTED_FAULT", "hang")
    watched = supervisor(store, RestartPolicy(silence_limit_s=0.5))
    watched.start()
    try:
        first = wait_for(lambda: watched.status.pid)
        wait_for(lambda: watched.status.restarts >= 1)
        assert watched.status.last_exit == "was killed by SIGKILL"
        assert not is_alive(first)
    finally:
        watched.close()


class WatchedProcess:
    """A worker that is looked at, and found silent for these times, until it is killed."""

    def __init__(self, store: PoseStore, monkeypatch: pytest.MonkeyPatch) -> None:
        self.silent_for_s: list[float] = []
        self.looks = 0
        self.is_killed = False
        self.stdin = None
        monkeypatch.setattr(store, "silent_for_s", lambda: self.silent_for_s[self.looks - 1])

    def wait(self, timeout_s: float) -> int:
        self.looks += 1
        if self.is_killed or self.looks > len(self.silent_for_s):
            return -9 if self.is_killed else 0
        raise subprocess.TimeoutExpired("worker", timeout_s)

    def kill(self) -> None:
        self.is_killed = True


@pytest.mark.parametrize(
    ("silent_for_s", "is_killed"),
    [
        ([0.1, 60.0, 0.1, 0.1], False),
        ([60.0, 60.2, 60.4, 60.6, 0.1], False),  # its first frame after the freeze takes a while
        ([0.1, 60.0, 0.1, 60.0, 0.1, 60.0, 0.1], False),
        ([0.25 * look for look in range(20)], True),
        ([60.0 + 0.25 * look for look in range(20)], True),
    ],
)
def test_a_worker_that_was_frozen_along_with_the_server_is_left_alone(
    store: PoseStore,
    monkeypatch: pytest.MonkeyPatch,
    silent_for_s: list[float],
    is_killed: bool,
) -> None:
    watched = supervisor(store, RestartPolicy(silence_limit_s=2.0))
    report = WorkerReport(boot_id="boot", phase=Phase.RUNNING, message="tracking")
    store.reports.write(report.model_dump_json().encode())
    process = WatchedProcess(store, monkeypatch)
    process.silent_for_s = silent_for_s
    watched._wait(cast("subprocess.Popen[bytes]", process), "boot")
    assert process.is_killed == is_killed


def test_a_worker_that_is_refused_at_first_is_left_alone(
    store: PoseStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCRIPTED_FAULT", "refused")
    watched = supervisor(store, RestartPolicy())
    watched.start()
    try:
        wait_for(lambda: watched.status.refused)
        assert (watched.status.pid, watched.status.restarts) == (None, 0)
    finally:
        watched.close()


def test_a_worker_that_has_tracked_before_is_tried_again_even_if_refused(
    store: PoseStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCRIPTED_FAULT", "refused")
    store.snapshots.write(b"{}")
    watched = supervisor(store, RestartPolicy(first_delay_s=0.05))
    watched.start()
    try:
        wait_for(lambda: watched.status.restarts >= 2)
        assert not watched.status.refused
    finally:
        watched.close()


def test_closing_waits_for_no_delay(store: PoseStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCRIPTED_FAULT", "refused")
    store.snapshots.write(b"{}")
    watched = supervisor(store, RestartPolicy(first_delay_s=30))
    watched.start()
    try:
        wait_for(lambda: watched.status.last_exit)
    finally:
        watched.close()
    assert watched.status.pid is None


def test_a_worker_that_cannot_be_started_is_tried_again(
    store: PoseStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    def no_process(*_: object, **__: object) -> None:
        tried.append(1)
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("snapfit.server.supervisor.subprocess.Popen", no_process)
    watched = supervisor(store, RestartPolicy(first_delay_s=0.01))
    watched.start()
    try:
        wait_for(lambda: len(tried) >= 3)
        assert watched.status.restarts >= 2
        assert "could not be started" in (watched.status.last_exit or "")
        assert watched.status.pid is None
    finally:
        watched.close()


def test_a_signal_without_a_name_is_told_by_its_number() -> None:
    assert describe_exit(-40) == "was killed by signal 40"
