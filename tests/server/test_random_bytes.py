"""Random bytes at every parameter of every operation: clear errors, and tracking goes on."""

from __future__ import annotations

import http.client
import json
import re
import socket
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from harness import Server, running, wait_for
from random_requests import HEADERS, Operation, RandomRequest, operations_of, random_request

DOCUMENT = Path(__file__).parents[2] / "openapi" / "openapi.json"
OPERATIONS = operations_of(json.loads(DOCUMENT.read_text(encoding="utf-8")))
STREAMS = ("/events", ".mjpeg")
MEMBERS = {"type", "title", "status", "detail", "instance"}
# Of a path that random bytes have made another one.
ELSEWHERE = {404, 405}
CLIENTS, TRIES = 4, 5
LATE = (b"problem:no-picture", b"problem:worker-unavailable")


@pytest.fixture(scope="module")
def target() -> Iterator[Server]:
    """One of its own: its state is changed at random."""
    with running("finds") as server:
        yield server.wait_ready()


def ask(server: Server, request: RandomRequest) -> tuple[int, str, bytes]:
    """Status, content type and body, of a stream only its beginning; 0 if there is no end to it."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as connection:
        connection.sendall(request.raw)
        if not request.is_framed:
            connection.shutdown(socket.SHUT_WR)  # the server may wait for more
        method = request.operation.method
        with closing(http.client.HTTPResponse(connection, method=method)) as answer:
            try:
                answer.begin()
            except http.client.RemoteDisconnected:
                assert not request.is_framed, request.raw
                return 0, "", b""
            kind = answer.headers.get("content-type", "")
            is_stream = answer.status < 400 and request.operation.path.endswith(STREAMS)
            return answer.status, kind, b"" if is_stream else answer.read()


def check(server: Server, request: RandomRequest) -> int:
    told = (request.operation.method, request.operation.path, request.raw)
    status, kind, body = ask(server, request)
    tries = 1
    # A busy machine is late with a picture or a command, which says so and asks to come again.
    while status == 503 and any(it in body for it in LATE) and tries < TRIES:
        time.sleep(1)
        status, kind, body = ask(server, request)
        tries += 1
    if status == 0:
        return status
    allowed = set(request.operation.statuses) - {429}
    if not request.is_of_operation:
        allowed |= ELSEWHERE | statuses_at(request)
    if not (request.is_http and request.is_framed):
        allowed.add(400)
    assert status in allowed, (status, body, *told)
    assert status < 500 or request.operation.path == "/readyz", (status, body, *told)
    if status >= 400 and request.operation.path != "/readyz":
        assert kind == "application/problem+json", (status, kind, body, *told)
        problem = json.loads(body)
        assert set(problem) >= MEMBERS, (problem, *told)
        assert problem["status"] == status, (problem, *told)
    return status


def statuses_at(request: RandomRequest) -> set[int]:
    """What other operations may answer at the path that the bytes have made."""
    found: set[int] = set()
    for operation in OPERATIONS:
        pattern = re.sub(r"{\w+}", ".+", operation.path)
        if operation.method == request.operation.method and re.fullmatch(pattern, request.path):
            found |= operation.statuses
    return found


def attack(server: Server, seed: int, rounds: int) -> Counter[int]:
    """Every place of every operation, so many times; and headers that all of them have."""
    before = server.get("/v1/poses").json()
    with ThreadPoolExecutor(CLIENTS) as clients:  # some are answered only when a frame comes
        statuses = Counter(
            clients.map(lambda request: check(server, request), random_requests(seed, rounds))
        )
    assert server.get("/healthz").status_code == 200
    wait_for(lambda: server.get("/v1/poses").json()["seq"] > before["seq"])
    wait_for(lambda: not server.get("/v1/poses").json()["stale"])
    assert server.get("/v1/poses").json()["boot_id"] == before["boot_id"]
    assert server.worker()["restarts"] == 0
    return statuses


def random_requests(seed: int, rounds: int) -> Iterator[RandomRequest]:
    rng = np.random.default_rng(seed)
    for turn in range(rounds):
        for number, operation in enumerate(OPERATIONS):
            common = HEADERS[(turn + number) % len(HEADERS)]
            for place, name in (*operation.slots(), ("header", common)):
                request = random_request(operation, place, name, rng)
                if not waits_long(operation, request):
                    yield request


def waits_long(operation: Operation, request: RandomRequest) -> bool:
    """A long poll that happens to be a valid one."""
    found = re.search(rb"timeout_s=([0-9.eE+%-]+)", request.raw)
    return "timeout_s" in operation.query and found is not None and found[1] != b"0.01"


@pytest.mark.parametrize(
    ("head", "status"),
    [
        (b"POST /v1/reset HTTP/1.1\r\nHost: h\r\nOrigin: http://[", 403),
        (b"POST /v1/reset HTTP/1.1\r\nHost:\r\nOrigin: null", 403),
        (b"GET /v1/stations/x HTTP/1.1\r\nHost: [", 404),
        (b"GET /v1/poses/?timeout_s=0 HTTP/1.1\r\nHost: h", 404),
        (b"GET /v1/poses HTTP/1.1\r\nHost: h\r\nCookie: \x00", 400),
        (b"snapfit?", 400),
    ],
)
def test_what_random_bytes_have_found(target: Server, head: bytes, status: int) -> None:
    with socket.create_connection(("127.0.0.1", target.port), timeout=10) as connection:
        connection.sendall(head + b"\r\nConnection: close\r\n\r\n")
        with closing(http.client.HTTPResponse(connection)) as answer:
            answer.begin()
            assert answer.status == status
            assert answer.headers["content-type"] == "application/problem+json"
            assert set(json.loads(answer.read())) >= MEMBERS


def test_a_few_hundred_random_requests(target: Server) -> None:
    statuses = attack(target, seed=1, rounds=2)
    assert sum(statuses.values()) >= 300
    assert {200, 404, 422} <= set(statuses)


@pytest.mark.slow
def test_thousands_of_random_requests() -> None:
    with running("finds") as server:
        server.wait_ready()
        statuses = attack(server, seed=2, rounds=20)
        assert sum(statuses.values()) >= 2000
        code, _, err = server.end()
    assert code == 0
    assert "Traceback" not in err
