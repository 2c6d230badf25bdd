"""When a worker is started again, and when not."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from harness import is_alive, wait_for, with_tests

from snapfit.server.clock import Clock
from snapfit.server.pose_store import PoseStore
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
    wait_for(lambda: watched.status.last_exit)
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
