"""Responses over a real connection, and when they came in."""

from __future__ import annotations

import select
import socket
import sys
import time
from collections.abc import Iterator

import pytest
from wire import Wire, now_us, number_after, request, response_bytes, status

OK = b"HTTP/1.1 200 OK\r\ncontent-length: 20\r\netag: x\r\n\r\n" + b'{"captured_at_us":7}'
NOTHING = b"HTTP/1.1 304 Not Modified\r\netag: x\r\n\r\n"


@pytest.fixture
def ends() -> Iterator[tuple[Wire, socket.socket]]:
    """A wire, and the server's end of it."""
    with socket.create_server(("127.0.0.1", 0)) as listener, select.epoll() as epoll:
        wire = Wire(listener.getsockname()[1], epoll)
        peer, _ = listener.accept()
        with peer:
            yield wire, peer
        wire.close()


def test_a_response_is_complete_with_its_last_byte() -> None:
    assert response_bytes(OK) == len(OK)
    assert response_bytes(OK[:30]) == 0
    assert response_bytes(NOTHING) == len(NOTHING)
    assert (status(OK), status(NOTHING), number_after(OK, b'"captured_at_us":')) == (200, 304, 7)


def test_a_response_in_pieces_and_two_at_once(ends: tuple[Wire, socket.socket]) -> None:
    wire, peer = ends
    wire.send(request("/v1/poses", {"If-None-Match": "x"}))
    assert (
        peer.recv(1000) == b"GET /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\nIf-None-Match: x\r\n\r\n"
    )
    peer.sendall(OK[:40])
    assert wire.response() is None
    peer.sendall(OK[40:] + NOTHING[:10])
    assert wire.response() == OK
    peer.sendall(NOTHING[10:])
    assert wire.response() == NOTHING


def test_a_server_that_leaves_is_told(ends: tuple[Wire, socket.socket]) -> None:
    wire, peer = ends
    peer.close()
    with pytest.raises(ConnectionError, match="closed"):
        wire.response()


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel's stamps are asked for on Linux")
def test_it_came_in_when_it_did_and_not_when_it_was_read(ends: tuple[Wire, socket.socket]) -> None:
    wire, peer = ends
    for _ in range(3):  # the first packets of all come without a stamp
        peer.sendall(OK)
        time.sleep(0.02)
        wire.response()
    sent_us = now_us()
    peer.sendall(OK)
    time.sleep(0.2)
    read_us = now_us()
    assert wire.response() == OK
    assert abs(wire.received_us - sent_us) < (read_us - sent_us) / 2
