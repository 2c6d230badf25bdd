"""Several machines: one works, others serve, and Redis between them comes and goes."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fleet import (
    Redis,
    WorkerMachine,
    is_fresh,
    needs_redis,
    redis_server,
    replica,
    working,
)
from harness import Server, is_alive, once_there, segments, segments_of, wait_for
from patience import within
from scripted_pipeline import PART_NAMES

from snapfit.server.schemas import PoseSnapshot

pytestmark = needs_redis


@pytest.fixture(scope="module")
def redis() -> Iterator[Redis]:
    with redis_server() as it:
        yield it


def info(server: Server) -> dict[str, Any]:
    found: dict[str, Any] = server.get("/v1/stations/bench-1").json()
    return found


def worker_pid(server: Server) -> int:
    """Once it is heard of."""
    pid: int = wait_for(lambda: info(server)["worker"]["pid"])
    return pid


def young_snapshot(server: Server) -> PoseSnapshot | None:
    """Where it came through without being held up."""
    snapshot = PoseSnapshot.model_validate_json(server.get("/v1/poses").content)
    return snapshot if snapshot.age_us < 200_000 else None


def are_close(one: Server, two: Server) -> bool:
    first, second = (server.get("/v1/poses").json() for server in (one, two))
    assert first["boot_id"] == second["boot_id"]
    return abs(first["seq"] - second["seq"]) < 10


def test_two_replicas_serve_what_one_machine_tracks(redis: Redis, tmp_path: Path) -> None:
    with replica(redis.url) as one, replica(redis.url) as two:
        assert one.get("/v1/poses").status_code == 503
        wait_for(lambda: "no worker has the lease" in info(one)["worker"]["message"])
        with working(tmp_path, redis.url):
            for server in (one, two):
                wait_for(lambda server=server: is_fresh(server))
                snapshot = wait_for(lambda server=server: young_snapshot(server))
                assert [part.part for part in snapshot.parts] == list(PART_NAMES)
                wait_for(lambda server=server: server.get("/readyz").status_code == 200)
                picture = once_there(lambda server=server: server.get("/v1/overlay.jpg"))
                assert picture.status_code == 200
                assert picture.content.startswith(b"\xff\xd8")
                wait_for(lambda server=server: info(server)["facts"])
                wait_for(lambda server=server: info(server)["worker"]["phase"] == "running")
            wait_for(lambda: are_close(one, two))


def test_a_worker_that_ends_gives_its_station_up_at_once(redis: Redis, tmp_path: Path) -> None:
    with replica(redis.url) as server:
        with working(tmp_path, redis.url) as machine:
            wait_for(lambda: is_fresh(server))
            own = segments_of(machine.process.pid)
            assert len(own) == 2
            assert machine.end()[0] == 0
        assert not own & segments()
        wait_for(lambda: not is_fresh(server), 3)
        wait_for(lambda: info(server)["worker"]["pid"] is None, 3)
        wait_for(lambda: info(server)["worker"]["phase"] == "failed", 3)
        assert server.get("/readyz").status_code == 503
        assert server.get("/v1/poses").json()["parts"][0]["position"] is not None


def test_a_machine_that_is_gone_loses_its_lease(redis: Redis, tmp_path: Path) -> None:
    with replica(redis.url) as server, working(tmp_path, redis.url) as machine:
        wait_for(lambda: is_fresh(server))
        worker = worker_pid(server)
        machine.end(signal.SIGKILL)
        wait_for(lambda: "no worker has the lease" in info(server)["worker"]["message"], 10)
        wait_for(lambda: info(server)["stale"])
        wait_for(lambda: not is_alive(worker), 10)
        with working(tmp_path, redis.url):
            wait_for(lambda: is_fresh(server))


def test_a_worker_that_dies_is_told_of_at_once(redis: Redis, tmp_path: Path) -> None:
    with replica(redis.url) as server, working(tmp_path, redis.url):
        wait_for(lambda: is_fresh(server))
        before = server.get("/v1/poses").json()["boot_id"]
        os.kill(worker_pid(server), signal.SIGKILL)

        def is_anew() -> bool:
            return server.get("/v1/poses").json()["boot_id"] != before

        wait_for(lambda: not is_fresh(server) or is_anew())
        wait_for(lambda: is_anew() and is_fresh(server))
        worker = wait_for(lambda: (it := info(server)["worker"])["restarts"] == 1 and it)
        assert worker["last_exit"] == "was killed by SIGKILL"


def test_a_second_machine_waits_and_takes_over(redis: Redis, tmp_path: Path) -> None:
    (tmp_path / "second").mkdir()
    with replica(redis.url) as server, working(tmp_path, redis.url) as first:
        wait_for(lambda: is_fresh(server))
        boot_id = server.get("/v1/poses").json()["boot_id"]
        with working(tmp_path / "second", redis.url) as second:
            wait_for(lambda: "is published by" in second.said.read()[1])
            assert server.get("/v1/poses").json()["boot_id"] == boot_id
            first.end(signal.SIGKILL)
            wait_for(lambda: server.get("/v1/poses").json()["boot_id"] != boot_id, 12)
            wait_for(lambda: is_fresh(server), 12)
            _, _, err = second.end()
        assert "station bench-1 is published by" in err
        assert "Traceback" not in err


def statuses_while(server: Server, seconds: float) -> dict[str, set[Any]]:
    """What is answered during some seconds: statuses by path, and whether poses are stale."""
    seen: dict[str, set[Any]] = {"stale": set()}
    end_s = time.monotonic() + seconds
    while not seen["stale"] or time.monotonic() < end_s:
        for path in ("/v1/poses", "/v1/poses/jaw", "/v1/stations", "/healthz", "/readyz"):
            answer = server.get(path)
            seen.setdefault(path, set()).add(answer.status_code)
            if path == "/v1/poses":
                seen["stale"].add(answer.json()["stale"])
        time.sleep(0.02)
    return seen


def assert_only_known_values(seen: dict[str, set[Any]]) -> None:
    for path in ("/v1/poses", "/v1/poses/jaw", "/v1/stations", "/healthz"):
        assert seen[path] == {200}, path


def test_the_api_outlives_ten_seconds_of_a_redis_that_hangs(tmp_path: Path) -> None:
    """One that is stopped: `test_fleet_shared`."""
    with redis_server() as redis, working(tmp_path, redis.url) as machine:
        with replica(redis.url) as server:
            wait_for(lambda: is_fresh(server))
            worker = wait_for(lambda: (it := info(server)["worker"])["pid"] and it)
            redis.signal(signal.SIGSTOP)
            begin_s = time.monotonic()
            # It is in the socket of a Redis that will read it when it goes on.
            order = server.client.put("/v1/assembly/state", json={"state": "assembled"})
            assert order.status_code == 503
            assert_only_known_values(statuses_while(server, 10 - (time.monotonic() - begin_s)))
            assert server.get("/v1/poses").json()["stale"]
            assert server.get("/readyz").status_code == 503
            assert "does not answer" in info(server)["worker"]["message"]
            redis.signal(signal.SIGCONT)
            back_at_s = time.monotonic()
            assert_only_known_values(statuses_while(server, 1))
            wait_for(lambda: is_fresh(server), 12)
            assert time.monotonic() - back_at_s < within(30)
            # The worker went on all the while, and what was refused is not done now.
            assert worker_pid(server) == worker["pid"]
            assert info(server)["worker"]["restarts"] == worker["restarts"]
            wait_for(lambda: server.get("/readyz").status_code == 200, 10)
            assert server.get("/v1/assembly").json()["state"] == "free"
            _, _, err = server.end()
        assert "Traceback" not in err
        assert err.count("trying again") <= 3
        code, _, err = machine.end()
    assert code == 0
    assert "Traceback" not in err
    assert err.count("trying again") <= 3


def test_a_replica_may_start_before_redis(tmp_path: Path) -> None:
    redis = Redis()
    try:
        with replica(redis.url) as server:
            assert server.get("/v1/poses").status_code == 503
            assert "does not answer" in info(server)["worker"]["message"]
            redis.start()
            with working(tmp_path, redis.url):
                wait_for(lambda: is_fresh(server))
    finally:
        redis.stop()


def test_a_replica_ends_cleanly(redis: Redis) -> None:
    with replica(redis.url) as server:
        own = segments_of(server.process.pid)
        code, _, err = server.end()
        # A Redis that is held up for a second is told of, which is no fault of the end.
        told = [line for line in err.splitlines() if "trying again" not in line]
        assert (code, told) == (0, [])
        assert len(own) == 2
        assert not own & segments()


def test_a_worker_that_is_refused_ends_with_its_words(
    redis: Redis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCRIPTED_FAULT", "refused")
    code, _, err = WorkerMachine(tmp_path, redis.url).end(0)
    assert code == 1
    assert "refused: station bench-1: demo: no such folder" in err
