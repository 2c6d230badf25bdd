"""Events: what is detected, what is kept, and how it comes over a real connection."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from event_client import EventClient
from harness import Server, running, wait_for
from patience import within

from snapfit.server.event_detector import EventDetector
from snapfit.server.events import EventKind, EventLog


def snapshot(poses: dict[str, bool], state: str = "free", done: int = 0, wrong: Any = ()) -> Any:
    steps = ["mount-jaw", "screw-bolt"]
    parts = [
        {"part": name, "status": "tracked" if is_seen else "lost",
         "position": [0, 0, 1] if is_seen else None}
        for name, is_seen in poses.items()
    ]  # fmt: skip
    assembly = {
        "state": state,
        "finished_steps": steps[:done],
        "misassemblies": list(wrong),
        "decided_by": "tracking",
        "confidence": 0.9,
    }
    return {"parts": parts, "assembly": assembly}


def told(detector: EventDetector, it: Any, *, stale: bool = False) -> list[tuple[str, Any]]:
    return [(str(kind), data) for kind, data in detector.happened(it, stale=stale)]


def test_the_first_snapshot_tells_which_parts_there_are() -> None:
    detector = EventDetector()
    first = snapshot({"base": True, "jaw": False}, "mounted", done=1)
    assert told(detector, first) == [("part_found", {"part": "base", "status": "tracked"})]
    assert told(detector, first) == []


def test_what_changes_is_told_once() -> None:
    detector = EventDetector()
    told(detector, snapshot({"base": True}))
    kinds = [kind for kind, _ in told(detector, snapshot({"base": False}, "done", done=2))]
    assert kinds == ["part_lost", "state_changed", "step_finished", "step_finished"]
    back = told(detector, snapshot({"base": True}, "free", done=0))
    assert back[1][1] == {
        "from_state": "done",
        "to_state": "free",
        "decided_by": "tracking",
        "confidence": 0.9,
    }
    assert [data["step"] for kind, data in back if kind == "step_undone"] == [
        "screw-bolt",
        "mount-jaw",
    ]


def test_each_mistake_is_told_once() -> None:
    detector = EventDetector()
    wrong = {"part": "pin", "parent": "base", "kind": "wrong_place"}
    told(detector, snapshot({}))
    assert told(detector, snapshot({}, wrong=[wrong])) == [("misassembled", wrong)]
    assert told(detector, snapshot({}, wrong=[wrong])) == []
    told(detector, snapshot({}))
    assert told(detector, snapshot({}, wrong=[wrong])) == [("misassembled", wrong)]


def test_stale_and_recovered_take_turns() -> None:
    detector = EventDetector()
    it = snapshot({"base": True})
    assert "stale" not in [kind for kind, _ in told(detector, it)]
    assert told(detector, it, stale=True) == [("stale", {})]
    assert told(detector, it, stale=True) == []
    assert told(detector, it) == [("recovered", {})]


def test_the_ring_is_bounded_and_says_what_it_lost() -> None:
    log = EventLog(kept=3)
    assert log.resume(log.event_id(0)) == 0
    for number in range(5):
        log.add(EventKind.STALE, {"number": number})
    assert [event.number for event in log.after(0)] == [3, 4, 5]
    assert log.resume(log.event_id(2)) == 2
    assert log.resume(log.event_id(1)) is None
    assert log.resume(log.event_id(6)) is None


@pytest.mark.parametrize("value", ["", "-", "3", "another-3", "x-", "-1", "é-٣", "9" * 70])
def test_another_servers_ids_are_not_ours(value: str) -> None:
    log = EventLog()
    log.add(EventKind.STALE, {})
    assert log.resume(value) is None
    assert log.resume(f"{log.run}-{value}") is None or value.isdecimal()


@pytest.fixture(scope="module")
def assembling() -> Iterator[Server]:
    with running("assembles") as server:
        yield server.wait_ready()


def test_events_come_in_order_with_what_they_belong_to(assembling: Server) -> None:
    client = EventClient(assembling)
    wanted = {"state_changed", "step_finished", "step_undone", "misassembled"}
    wanted |= {"part_found", "part_lost"}
    wait_for(lambda: wanted <= set(client.kinds()), 15)
    client.close()
    numbers = [int(event.id.rpartition("-")[2]) for event in client.events]
    assert all(b == a + 1 for a, b in pairwise(numbers))
    for event in client.events:
        assert event.data["station"] == "bench-1"
        assert event.data["seq"] > 0
        assert event.data["at_us"] >= event.data["captured_at_us"]
    states = [event.data for event in client.events if event.kind == "state_changed"]
    assert all(a["to_state"] == b["from_state"] for a, b in pairwise(states))
    assert {data["decided_by"] for data in states} == {"tracking"}
    wrong = next(event.data for event in client.events if event.kind == "misassembled")
    assert (wrong["part"], wrong["kind"]) == ("pin", "wrong_place")


def test_an_event_comes_soon_after_its_frame(assembling: Server) -> None:
    client = EventClient(assembling)
    wait_for(lambda: len(client.events) >= 8, 15)
    client.close()
    offset_us = assembling.get("/v1/time").json()["sent_at_us"] - time.time_ns() / 1000
    delays_ms = [(e.at_us + offset_us - e.data["captured_at_us"]) / 1e3 for e in client.events]
    # The quickest ones, because this machine may have other things to do.
    assert np.percentile(delays_ms, 10) < within(60)


def test_a_client_that_comes_back_misses_nothing(assembling: Server) -> None:
    first = EventClient(assembling)
    wait_for(lambda: len(first.events) >= 3, 15)
    first.close()
    last = first.events[2]
    time.sleep(1)
    second = EventClient(assembling, last.id)
    wait_for(lambda: len(second.events) >= 4, 15)
    second.close()
    begin = int(last.id.rpartition("-")[2])
    numbers = [int(event.id.rpartition("-")[2]) for event in second.events]
    assert numbers[:4] == list(range(begin + 1, begin + 5))


def test_a_client_of_an_earlier_run_is_told_that_it_missed_some(assembling: Server) -> None:
    client = EventClient(assembling, "00000000-17")
    missed = client.wait_for("missed")
    assert client.kinds()[0] == "missed"
    client.close()
    again = EventClient(assembling, missed.id)
    wait_for(lambda: again.events, 15)
    again.close()
    assert "missed" not in again.kinds()
    assert again.events[0].id == next_id(missed.id)


def next_id(event_id: str) -> str:
    run, _, number = event_id.rpartition("-")
    return f"{run}-{int(number) + 1}"


def test_who_is_cut_off_before_the_first_event_misses_nothing(assembling: Server) -> None:
    first = EventClient(assembling)
    first.close()
    other = EventClient(assembling, first.begin_id)
    wait_for(lambda: len(other.events) >= 3, 15)
    other.close()
    second = EventClient(assembling, first.begin_id)
    wait_for(lambda: second.events, 15)
    second.close()
    assert second.events[0].id == other.events[0].id == next_id(first.begin_id)


def test_a_dead_worker_is_told_and_its_return_too() -> None:
    with running() as server:
        server.wait_ready()
        client = EventClient(server)
        os.kill(server.worker()["pid"], signal.SIGKILL)
        client.wait_for("stale")
        client.wait_for("recovered")
        assert client.kinds().index("stale") < client.kinds().index("recovered")
        code, _, err = server.end()
        assert code == 0
        assert "Traceback" not in err
        client.join()
        client.close()


@pytest.mark.slow
def test_a_quiet_stream_has_a_heartbeat(server: Server) -> None:
    client = EventClient(server)
    wait_for(lambda: client.comments >= 2, 25)
    client.close()


def test_an_unknown_station_has_no_events(server: Server) -> None:
    answer = server.get("/v1/stations/bench-9/events")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


def test_an_overlong_id_is_refused(server: Server) -> None:
    answer = server.get("/v1/events", headers={"Last-Event-ID": "x" * 65})
    assert answer.status_code == 422
