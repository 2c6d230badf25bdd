"""Poses in other conventions, at other times, and when they come: through a real server."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import golden_conventions
import numpy as np
import pytest
from harness import Server, running, wait_for
from patience import within
from scripted_pipeline import FRAME_RATE_HZ, LOST_PART, X_VELOCITY_M_PER_S

from snapfit.server.schemas import PartSnapshot, PoseSnapshot

GOLDEN: dict[str, Any] = json.loads(golden_conventions.FILE.read_text(encoding="utf-8"))
PERIOD_S = 1 / FRAME_RATE_HZ


def same_snapshot(server: Server, *paths: str) -> list[dict[str, Any]]:
    """Answers that belong to one snapshot."""

    def ask() -> list[dict[str, Any]] | None:
        answers = [server.get(path).json() for path in paths]
        return answers if len({answer["seq"] for answer in answers}) == 1 else None

    found: list[dict[str, Any]] = wait_for(ask)
    return found


@pytest.mark.parametrize("convention", GOLDEN["conventions"])
def test_every_convention_is_the_golden_matrix_away(server: Server, convention: str) -> None:
    plain, converted = same_snapshot(server, "/v1/poses", f"/v1/poses?convention={convention}")
    PoseSnapshot.model_validate(converted)
    assert converted["convention"] == convention
    b = np.array(GOLDEN["conventions"][convention]["convention_from_opencv"])
    for before, after in zip(plain["parts"], converted["parts"], strict=True):
        if before["part"] == LOST_PART:
            assert (after["position"], after["orientation"], after["covariance"]) == (None,) * 3
            continue
        np.testing.assert_allclose(after["position"], b @ before["position"])
        turned = round(np.linalg.det(b)) * b @ before["orientation"][:3]
        np.testing.assert_allclose(after["orientation"], [*turned, before["orientation"][3]])
        assert after["covariance"][0] == before["covariance"][0]


def test_one_part_is_converted_like_all(server: Server) -> None:
    every, one = same_snapshot(
        server, "/v1/poses?convention=unity", "/v1/poses/jaw?convention=unity"
    )
    PartSnapshot.model_validate(one)
    assert one["pose"] == every["parts"][1]


def test_poses_are_extrapolated_to_the_time_that_is_asked_for(server: Server) -> None:
    def ask() -> tuple[dict[str, Any], dict[str, Any]] | None:
        first = server.get("/v1/poses/jaw").json()
        at_us = first["captured_at_us"] + 50_000
        later = server.get(f"/v1/poses/jaw?at_us={at_us}").json()
        return (first, later) if first["seq"] == later["seq"] > 1 else None

    first, later = wait_for(ask)
    assert (later["at_us"], later["at_clamped"]) == (first["captured_at_us"] + 50_000, False)
    before, after = first["pose"], later["pose"]
    moved_m = after["position"][0] - before["position"][0]
    assert moved_m == pytest.approx(0.05 * X_VELOCITY_M_PER_S, rel=0.01)
    assert after["covariance"][35] > before["covariance"][35]


def test_beyond_a_tenth_of_a_second_the_answer_says_so(server: Server) -> None:
    now_us = server.get("/v1/time").json()["sent_at_us"]
    answer = server.get(f"/v1/poses?at_us={now_us + 5_000_000}").json()
    assert answer["at_clamped"] is True
    assert answer["at_us"] == answer["captured_at_us"] + 100_000


def test_a_clock_that_is_far_off_is_told_so(server: Server) -> None:
    answer = server.get("/v1/poses?at_us=1700000000000000")
    assert answer.status_code == 409
    assert answer.json()["type"] == "urn:snapfit:problem:at-out-of-range"
    assert abs(answer.json()["now_us"] - time.time_ns() / 1000) < 5e6


def test_each_view_is_an_entity_of_its_own(server: Server) -> None:
    plain, unity = same_snapshot(server, "/v1/poses", "/v1/poses?convention=unity")
    assert plain["seq"] == unity["seq"]
    tags = {server.get(f"/v1/poses{query}").headers["etag"] for query in ("", "?convention=ros")}
    assert len(tags) == 2


@pytest.mark.parametrize("path", ["/v1/poses", "/v1/poses/jaw", "/v1/stations/bench-1/poses"])
def test_a_long_poll_brings_every_snapshot_as_it_comes(server: Server, path: str) -> None:
    answer = server.get(path).json()
    begin_s = time.monotonic()
    seqs = []
    for _ in range(10):
        query = f"?after_seq={answer['seq']}&boot_id={answer['boot_id']}&timeout_s=5"
        answer = server.get(path + query).json()
        seqs.append(answer["seq"])
    assert seqs == sorted(set(seqs))
    assert time.monotonic() - begin_s > 6 * PERIOD_S


def test_a_long_poll_answers_soon_after_the_snapshot_is_there(server: Server) -> None:
    delays_ms = []
    answer = server.get("/v1/poses").json()
    for _ in range(30):
        query = f"?after_seq={answer['seq']}&boot_id={answer['boot_id']}"
        answer = server.get("/v1/poses" + query).json()
        now_us = server.get("/v1/time").json()["received_at_us"]
        delays_ms.append((now_us - answer["published_at_us"]) / 1e3)
    # The quickest ones, because this machine may have other things to do.
    assert np.percentile(delays_ms, 10) < within(25)


def test_without_a_boot_id_another_seq_is_waited_for(server: Server) -> None:
    assert server.get("/v1/poses?after_seq=1000000").status_code == 200
    seq = server.get("/v1/poses").json()["seq"]
    assert server.get(f"/v1/poses?after_seq={seq}&timeout_s=5").json()["seq"] > seq


def test_another_boot_id_is_answered_at_once(server: Server) -> None:
    begin_s = time.monotonic()
    answer = server.get("/v1/poses?after_seq=1000000&boot_id=another&timeout_s=10")
    assert answer.status_code == 200
    assert time.monotonic() - begin_s < within(2)


def test_without_a_newer_snapshot_there_is_no_content(server: Server) -> None:
    boot_id = server.get("/v1/poses").json()["boot_id"]
    begin_s = time.monotonic()
    answer = server.get(f"/v1/poses?after_seq=1000000&boot_id={boot_id}&timeout_s=0.3")
    assert 0.25 < time.monotonic() - begin_s < within(2)
    assert (answer.status_code, answer.content) == (204, b"")
    assert answer.headers["etag"].endswith('-fresh"')


def test_a_long_poll_ends_when_the_snapshot_becomes_stale() -> None:
    with running("end") as server:
        wait_for(server.answers)
        wait_for(lambda: server.worker()["phase"] == "ended")
        last = server.get("/v1/poses").json()
        query = f"?after_seq={last['seq']}&boot_id={last['boot_id']}&timeout_s=5"
        begin_s = time.monotonic()
        answer = server.get(f"/v1/poses{query}")
        assert (answer.status_code, answer.json()["stale"]) == (200, True)
        if not last["stale"]:
            assert time.monotonic() - begin_s < within(2)
        # Whoever knows that it is stale waits until something else happens.
        begin_s = time.monotonic()
        answer = server.get(f"/v1/poses{query.replace('timeout_s=5', 'timeout_s=0.5')}")
        assert time.monotonic() - begin_s > 0.4
        assert (answer.status_code, answer.json()["stale"]) == (200, True)


def test_waiting_clients_do_not_hold_up_the_end_of_the_server(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SNAPFIT_STATION__STALE_AFTER_S", "20")  # else they would end by that
    with running() as server, ExitStack() as open_now:
        boot_id = server.wait_ready().get("/v1/poses").json()["boot_id"]
        path = f"/v1/poses?after_seq=1000000&boot_id={boot_id}&timeout_s=60"
        wires = [open_now.enter_context(connected(server)) for _ in range(4)]
        for wire in wires:
            wire.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
        assert server.answers()  # the server has read what was sent before this
        begin_s = time.monotonic()
        code, _, err = server.end()
        assert (code, err) == (0, "")
        assert time.monotonic() - begin_s < within(15)
        for wire in wires:
            assert wire.recv(4096).startswith(b"HTTP/1.1 204 ")


@contextmanager
def connected(server: Server) -> Iterator[socket.socket]:
    """A connection that the server has taken."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=within(60)) as wire:
        wire.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        answer = b""
        while not answer.endswith(b"}"):
            answer += wire.recv(4096)
        assert answer.startswith(b"HTTP/1.1 200 ")
        yield wire
