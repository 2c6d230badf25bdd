"""The WebSocket and motion JPEG; clients that are slow, that leave, that never read."""

from __future__ import annotations

import json
import socket
import time
from typing import Any

import httpx
import numpy as np
import pytest
from harness import Server, dropped_clients, running, wait_for
from patience import within
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from snapfit.server.schemas import PoseSnapshot

GIVEN_UP_S = 30


def stream(server: Server, path: str = "/v1/stream") -> ClientConnection:
    address = f"ws://127.0.0.1:{server.port}{path}"
    return connect(address, proxy=None, legacy=True, ping_interval=None)


def take(connection: ClientConnection, count: int) -> list[dict[str, Any]]:
    return [json.loads(connection.recv(timeout=60)) for _ in range(count)]


@pytest.mark.parametrize("path", ["/v1/stream", "/v1/stations/bench-1/stream"])
def test_every_snapshot_comes_as_it_is_made(server: Server, path: str) -> None:
    def are_all_there() -> bool:
        """Whether next to none was left out, as it is where nobody is held up meanwhile."""
        with stream(server, path) as connection:
            snapshots = take(connection, 20)
        PoseSnapshot.model_validate(snapshots[-1])
        seqs = [it["seq"] for it in snapshots]
        assert seqs == sorted(set(seqs))
        return seqs[-1] - seqs[0] < 25 and np.median([it["age_us"] for it in snapshots]) < 40_000

    wait_for(are_all_there)


def test_it_comes_in_the_convention_that_is_asked_for(server: Server) -> None:
    with stream(server, "/v1/stream?convention=unity") as connection:
        (snapshot,) = take(connection, 1)
    assert snapshot["convention"] == "unity"
    assert snapshot["parts"][0]["position"][1] == pytest.approx(-0.02)


@pytest.mark.parametrize(
    ("path", "status", "kind"),
    [
        ("/v1/stream?convention=unreal", 422, "invalid-request"),
        ("/v1/stream?speed=1", 422, "invalid-request"),
        ("/v1/stations/bench-9/stream", 404, "unknown-station"),
    ],
)
def test_what_cannot_be_streamed_is_a_problem(
    server: Server, path: str, status: int, kind: str
) -> None:
    with pytest.raises(InvalidStatus) as refused:
        stream(server, path)
    response = refused.value.response
    assert response.status_code == status
    assert response.headers["content-type"] == "application/problem+json"
    assert json.loads(response.body)["type"] == f"urn:snapfit:problem:{kind}"


def test_a_client_that_comes_and_goes_leaves_nothing_behind(server: Server) -> None:
    for _ in range(20):
        with stream(server) as connection:
            take(connection, 1)
    sudden = stream(server)
    sudden.socket.close()
    assert server.get("/v1/poses").status_code == 200


def test_what_a_client_says_does_not_matter(server: Server) -> None:
    with stream(server) as connection:
        connection.send("{not json")
        connection.send(b"\x00" * 1000)
        take(connection, 3)


def silent_client(port: int, request: bytes) -> socket.socket:
    """Asks, then never reads."""
    client = socket.create_connection(("127.0.0.1", port), timeout=60)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.sendall(request)
    return client


HANDSHAKE = (
    b"GET /v1/stream HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def test_a_client_that_never_reads_is_dropped_and_nobody_else_notices() -> None:
    with running() as server:
        server.wait_ready()
        silent = [silent_client(server.port, HANDSHAKE) for _ in range(3)]
        begin_s = time.monotonic()
        with stream(server) as connection:
            got = take(connection, 30)
            while dropped_clients(server) < 3:
                assert time.monotonic() - begin_s < within(120)
                got += take(connection, 30)
        assert np.percentile([it["age_us"] for it in got], 90) < 1e5 * within(1)
        assert len(got) > 0.8 * (got[-1]["seq"] - got[0]["seq"])
        for client in silent:
            with pytest.raises(OSError, match=r"reset|closed|Broken pipe|timed out"):
                read_to_the_end(client)
            client.close()
        _, _, err = server.end()
        assert err.count("/v1/stream: a client that does not read is dropped") == 3
        assert "Traceback" not in err


def read_to_the_end(client: socket.socket) -> None:
    """What still lies in the system's buffers, then the connection's end."""
    client.settimeout(1)
    total = 0
    while data := client.recv(65536):
        total += len(data)
        assert total < 2_000_000, "the server goes on sending"
    raise ConnectionResetError("closed")


def test_streams_end_when_the_server_does() -> None:
    with running() as server:
        server.wait_ready()
        connection = stream(server)
        take(connection, 2)
        with httpx.stream("GET", f"http://127.0.0.1:{server.port}/v1/frame.mjpeg") as film:
            next(film.iter_raw())
            begin_s = time.monotonic()
            code, _, err = server.end()
            assert (code, err) == (0, "")
            assert time.monotonic() - begin_s < within(10)
        with pytest.raises(ConnectionClosed):
            take(connection, 1000)


@pytest.mark.parametrize("kind", ["frame", "overlay"])
def test_a_film_is_one_jpeg_after_the_other(server: Server, kind: str) -> None:
    import cv2

    film: bytes = wait_for(lambda: some_pictures(server, f"/v1/{kind}.mjpeg"))
    parts = film.split(b"--frame\r\n")[1:-1]
    stamps = []
    for part in parts:
        head, _, jpeg = part.partition(b"\r\n\r\n")
        fields = dict(line.split(b": ") for line in head.split(b"\r\n"))
        length = int(fields[b"Content-Length"])
        assert jpeg[length:] == b"\r\n"
        assert cv2.imdecode(np.frombuffer(jpeg[:length], np.uint8), 1).shape == (180, 320, 3)
        stamps.append(int(fields[b"Captured-At-Us"]))
    assert stamps == sorted(set(stamps))


def some_pictures(server: Server, path: str) -> bytes | None:
    """The beginning of a film; None where the worker was too busy for its first picture."""
    received = b""
    with server.client.stream("GET", path) as film:
        if film.status_code == 503:
            return None
        assert film.headers["content-type"] == "multipart/x-mixed-replace; boundary=frame"
        for chunk in film.iter_raw():
            received += chunk
            if received.count(b"--frame") > 5:
                break
    return received


def test_a_film_without_a_frame_is_a_problem() -> None:
    with running("slow-start") as server:
        wait_for(server.answers)
        with server.client.stream("GET", "/v1/overlay.mjpeg") as answer:  # a film has no end
            assert answer.status_code == 503
