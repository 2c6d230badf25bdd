"""/metrics in Prometheus' format, and the clock."""

from __future__ import annotations

import time

import pytest
from folder_server import STALE_AFTER_S
from harness import Server, running, wait_for
from prometheus_client.parser import text_string_to_metric_families
from test_api import assert_problem

from snapfit.server.state_clock import StateClock


def samples(server: Server) -> dict[tuple[str, ...], float]:
    text = server.get("/metrics").text
    return {
        (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_the_station_is_measured(server: Server) -> None:
    found = samples(server)
    station = "bench-1"
    assert found["snapfit_worker_up", station] == 1
    assert found["snapfit_stale", station] == 0
    assert 0 < found["snapfit_pose_age_seconds", station] < STALE_AFTER_S
    assert found["snapfit_part_confidence", "jaw", station] == pytest.approx(0.97)
    assert found["snapfit_part_tracked", "cap", station] == 0
    assert found["snapfit_assembly_state", "free", station] == 1
    wait_for(lambda: samples(server).get(("snapfit_frame_seconds", station)) == 0.001)
    begin_s = time.monotonic()
    in_free = ("snapfit_assembly_state_seconds_total", "free", station)
    before = samples(server)[in_free]
    time.sleep(0.3)
    after = wait_for(lambda: (it := samples(server)[in_free]) > before + 0.25 and it)
    # Its clock goes on by the snapshots, of which the last may be a little old.
    assert after - before < time.monotonic() - begin_s + 0.5


def test_requests_are_counted_by_route(server: Server) -> None:
    def count(*labels: str) -> float:
        return samples(server).get(("snapfit_request_seconds_count", *labels), 0)

    fast = count("GET", "/v1/poses", "200")
    part = count("GET", "/v1/poses/{part}", "200")
    unknown = count("GET", "/v1/stations/{station}/poses/{part}", "404")
    nothing = count("GET", "unknown", "404")
    server.get("/v1/poses")
    server.get("/v1/poses?convention=ros")
    server.get("/v1/poses/jaw")
    server.get("/v1/stations/bench-1/poses/jew")
    server.get("/v1/nothing/here")
    assert count("GET", "/v1/poses", "200") == fast + 2
    assert count("GET", "/v1/poses/{part}", "200") == part + 1
    assert count("GET", "/v1/stations/{station}/poses/{part}", "404") == unknown + 1
    assert count("GET", "unknown", "404") == nothing + 1
    assert not any("jew" in label for key in samples(server) for label in key)


def test_a_dead_worker_is_seen() -> None:
    with running("end") as server:
        wait_for(server.answers)
        wait_for(lambda: server.worker()["phase"] == "ended")
        wait_for(lambda: samples(server)["snapfit_stale", "bench-1"] == 1)


def test_the_state_clock_adds_up() -> None:
    clock = StateClock()
    assert clock.seconds() == {}
    clock.enter("free")
    time.sleep(0.02)
    clock.enter("done")
    clock.enter("done")
    time.sleep(0.02)
    clock.enter(None)
    held = clock.seconds()
    time.sleep(0.02)
    assert clock.seconds() == held
    assert held["free"] >= 0.02
    assert held["done"] >= 0.02
    clock.enter("free")
    time.sleep(0.01)
    assert clock.seconds()["free"] > held["free"]


def test_four_stamps_find_the_offset(server: Server) -> None:
    least_us, most_us = [], []
    for _ in range(5):
        c1 = time.time_ns() // 1000
        answer = server.get(f"/v1/time?client_sent_at_us={c1}").json()
        c2 = time.time_ns() // 1000
        assert answer["client_sent_at_us"] == c1
        t1, t2 = answer["received_at_us"], answer["sent_at_us"]
        assert t1 <= t2
        round_trip_us = (c2 - c1) - (t2 - t1)
        assert round_trip_us >= 0
        offset_us = ((t1 - c1) + (t2 - c2)) / 2
        least_us.append(offset_us - round_trip_us / 2)
        most_us.append(offset_us + round_trip_us / 2)
    # The true one lies within each round trip, so they have some in common.
    assert max(least_us) <= min(most_us) + 1000


@pytest.mark.parametrize("stamp", ["-1", "now", "1.5", "9007199254740993"])
def test_a_wrong_stamp_is_refused(server: Server, stamp: str) -> None:
    assert_problem(server.get(f"/v1/time?client_sent_at_us={stamp}"), 422, "/v1/time")
