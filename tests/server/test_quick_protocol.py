"""What the fast lane answers on the wire: pieces, pipelining, closing, waiting, leaving."""

from __future__ import annotations

import asyncio
import json
import select
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from harness import Server, wait_for
from patience import within
from test_metrics import samples

from snapfit.server.bell import Bell
from snapfit.server.waiting import Waiting

POLL = b"GET /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"


@contextmanager
def connected(server: Server) -> Iterator[socket.socket]:
    with socket.create_connection(("127.0.0.1", server.port), timeout=within(10)) as wire:
        yield wire


def request(path: str, *headers: str, version: str = "1.1") -> bytes:
    return "\r\n".join([f"GET {path} HTTP/{version}", "Host: 127.0.0.1", *headers, "", ""]).encode()


def answers(wire: socket.socket, count: int) -> list[tuple[int, dict[str, str], bytes]]:
    """So many answers: status, headers, body."""
    found, data = [], b""
    while len(found) < count:
        head, complete, rest = data.partition(b"\r\n\r\n")
        if complete:
            first, *lines = head.decode().split("\r\n")
            headers = dict(line.split(": ", 1) for line in lines)
            length = int(headers.get("content-length", 0))
            if len(rest) >= length:
                found.append((int(first.split()[1]), headers, rest[:length]))
                data = rest[length:]
                continue
        more = wire.recv(65536)
        assert more, f"closed after {len(found)} answers"
        data += more
    assert data == b""
    return found


def is_closed(wire: socket.socket) -> bool:
    return wire.recv(1) == b""


def revision(server: Server) -> tuple[str, int]:
    assembly = server.get("/v1/assembly").json()
    return assembly["boot_id"], assembly["revision"]


def test_a_request_in_pieces_is_one_request(server: Server) -> None:
    with connected(server) as wire:
        for at in range(0, len(POLL), 7):
            wire.sendall(POLL[at : at + 7])
        (status, headers, body), *_ = answers(wire, 1)
        assert status == 200
        assert json.loads(body)["station"] == "bench-1"
        assert headers["x-content-type-options"] == "nosniff"
        assert "date" in headers


def test_requests_in_one_packet_are_answered_in_order(server: Server) -> None:
    paths = ["/v1/poses", "/v1/stations", "/v1/assembly", "/v1/nothing", "/v1/poses"]
    with connected(server) as wire:
        wire.sendall(b"".join(map(request, paths)))
        found = answers(wire, len(paths))
    assert [status for status, *_ in found] == [200, 200, 200, 404, 200]
    keys = [set(json.loads(body)) for *_, body in found]
    assert "parts" in keys[0] & keys[4]
    assert "stations" in keys[1]
    assert "revision" in keys[2]


def test_what_follows_a_long_poll_waits_for_it(server: Server) -> None:
    boot_id, known = revision(server)
    path = f"/v1/assembly?boot_id={boot_id}&after_revision={known}&timeout_s=0.3"
    with connected(server) as wire:
        wire.sendall(request(path) + POLL)
        found = answers(wire, 2)
    assert [status for status, *_ in found] == [204, 200]
    assert found[0][2] == b""


@pytest.mark.parametrize(
    "asked",
    [
        request("/v1/poses", "Connection: close"),
        request("/v1/assembly?after_revision=0&timeout_s=0.1", "Connection: close"),
        request("/v1/poses", version="1.0"),
    ],
)
def test_who_wants_no_other_answer_is_told_and_left(server: Server, asked: bytes) -> None:
    with connected(server) as wire:
        wire.sendall(asked)
        (status, headers, _), *_ = answers(wire, 1)
        assert status in (200, 204)
        assert headers["connection"] == "close"
        assert is_closed(wire)


def test_who_asks_every_few_seconds_keeps_the_connection(server: Server) -> None:
    with connected(server) as wire:
        for wait_s in (0, 6):  # longer than uvicorn keeps it unless it is told to
            assert select.select([wire], [], [], wait_s)[0] == []
            wire.sendall(POLL)
            assert answers(wire, 1)[0][0] == 200


def test_a_get_with_a_body_is_read_to_its_end(server: Server) -> None:
    with connected(server) as wire:
        wire.sendall(request("/v1/poses", "Content-Length: 5") + b"hello" + POLL)
        assert [status for status, *_ in answers(wire, 2)] == [200, 200]


def test_a_long_poll_is_counted_once_it_is_answered(server: Server) -> None:
    labels = ("snapfit_request_seconds_count", "GET", "/v1/assembly", "204")
    before = samples(server).get(labels, 0)
    boot_id, known = revision(server)
    path = f"/v1/assembly?boot_id={boot_id}&after_revision={known}&timeout_s=0.2"
    with connected(server) as wire:
        wire.sendall(request(path))
        answers(wire, 1)
    assert samples(server)[labels] == before + 1


def test_a_client_that_leaves_while_it_waits_troubles_nobody(server: Server) -> None:
    boot_id, known = revision(server)
    path = f"/v1/poses?boot_id={boot_id}&after_seq={2**40}&timeout_s=30"
    for _ in range(20):
        with connected(server) as wire:
            wire.sendall(request(path))
    assert revision(server) == (boot_id, known)
    wait_for(lambda: server.get("/v1/poses").json()["boot_id"] == boot_id)


def told_after(answers_of: list[bool | None], limit_s: float, rings: int) -> list[bool]:
    """What one who waits is told, where a bell rings so often."""

    async def wait() -> list[bool]:
        bell, told, asked = Bell(), list[bool](), iter(answers_of)
        Waiting(lambda: next(asked), bell, limit_s, told.append)
        for _ in range(rings):
            bell.ring()
            await asyncio.sleep(0)
        await asyncio.sleep(0.05)
        bell.ring()
        return told

    return asyncio.run(wait())


@pytest.mark.parametrize(
    ("answers_of", "limit_s", "rings", "told"),
    [
        ([True], 5.0, 1, [True]),
        ([None, None, True], 5.0, 3, [True]),
        ([False], 5.0, 1, [False]),
        ([], 0.01, 0, [False]),
        ([], -1.0, 0, [False]),
        ([True], 5.0, 3, [True]),
    ],
)
def test_who_waits_is_told_once(
    answers_of: list[bool | None], limit_s: float, rings: int, told: list[bool]
) -> None:
    assert told_after(answers_of, limit_s, rings) == told


@pytest.mark.parametrize("has_rung", [False, True])
def test_who_is_forgotten_is_told_nothing(has_rung: bool) -> None:
    async def forget() -> list[Any]:
        bell, told = Bell(), list[Any]()
        waiting = Waiting(lambda: True, bell, 0.01, told.append)
        if has_rung:
            bell.ring()
        waiting.forget()
        await asyncio.sleep(0.03)
        bell.ring()
        return told

    assert asyncio.run(forget()) == []
