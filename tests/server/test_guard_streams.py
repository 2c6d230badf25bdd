"""Streams and WebSockets at the door: who may open one, and how it ends with its key."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from starlette.types import Message, Receive, Scope, Send

from snapfit.server.security.access import Access
from snapfit.server.security.guard import Guard
from snapfit.server.security.key_file import add_key, remove_key
from snapfit.server.security.key_ring import KeyRing
from snapfit.server.security.roles import Role
from snapfit.server.security.settings import SecuritySettings

HOST = "bench:8000"


def scope(kind: str, **headers: str) -> Scope:
    pairs = [(name.encode(), value.encode()) for name, value in {"host": HOST, **headers}.items()]
    return {
        "type": kind,
        "path": "/v1/stream",
        "raw_path": b"/v1/stream",
        "query_string": b"",
        "headers": pairs,
        "client": ("10.0.0.9", 1),
        "scheme": "http",
        "extensions": {"websocket.http.response": {}},
        **({"method": "GET"} if kind == "http" else {}),
    }


async def endless_socket(_scope: Scope, _receive: Receive, send: Send) -> None:
    await send({"type": "websocket.accept"})
    while True:
        await send({"type": "websocket.send", "text": "pose"})
        await asyncio.sleep(0)


async def endless_answer(_scope: Scope, _receive: Receive, send: Send) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    while True:
        await send({"type": "http.response.body", "body": b"pose", "more_body": True})
        await asyncio.sleep(0)


class Door:
    """A guard, and what came out of it."""

    def __init__(self, path: Path, **settings: Any) -> None:
        self.ring = KeyRing(path)
        self.access = Access(SecuritySettings(**settings), self.ring, ())
        self.sent: list[Message] = []

    async def open(self, app: Any, asked: Scope, at_message: Any = None) -> None:
        async def receive() -> Message:
            return {"type": "http.request"}

        async def send(message: Message) -> None:
            self.sent.append(message)
            if at_message is not None and len(self.sent) == 5:
                at_message()
            if len(self.sent) > 1000:
                raise TimeoutError("it never ends")

        await Guard(app, self.access)(asked, receive, send)


@pytest.fixture
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, str]:
    monkeypatch.setattr("snapfit.server.security.key_ring._LOOK_PERIOD_S", 0.0)
    path = tmp_path / "keys.json"
    return path, add_key(path, "headset", Role.READ)


@pytest.mark.parametrize(
    ("kind", "app", "end"),
    [
        ("websocket", endless_socket, {"type": "websocket.close", "code": 1008}),
        ("http", endless_answer, {"type": "http.response.body", "body": b""}),
    ],
)
def test_a_stream_ends_with_its_key(
    keys: tuple[Path, str], kind: str, app: Any, end: Message
) -> None:
    path, key = keys
    door = Door(path)
    asked = scope(kind, authorization=f"Bearer {key}")
    asyncio.run(door.open(app, asked, lambda: remove_key(path, "headset")))
    assert len(door.sent) == 6
    assert door.sent[-1] == end


@pytest.mark.parametrize(
    ("headers", "status"),
    [({}, 401), ({"authorization": "Bearer x"}, 401), ({"cookie": "snapfit_session=x.y"}, 401)],
)
def test_a_socket_without_a_key_is_refused_before_it_opens(
    keys: tuple[Path, str], headers: dict[str, str], status: int
) -> None:
    door = Door(keys[0])
    asyncio.run(door.open(endless_socket, scope("websocket", **headers)))
    start = door.sent[0]
    assert (start["type"], start["status"]) == ("websocket.http.response.start", status)


@pytest.mark.parametrize(
    ("origin", "opens"),
    [
        (f"http://{HOST}", True),
        ("https://dash.example", True),
        ("http://evil.example", False),
        ("http://bench:9000", False),
        ("null", False),
    ],
)
def test_a_session_opens_sockets_for_pages_of_this_server_alone(
    keys: tuple[Path, str], origin: str, opens: bool
) -> None:
    path, key = keys
    door = Door(path, cors_origins=("https://dash.example",))

    async def try_it() -> None:
        record = await door.ring.of_key(key)
        assert record is not None
        cookie = f"a=b; snapfit_session={door.ring.new_session(record)}"
        asked = scope("websocket", cookie=cookie, origin=origin)
        await door.open(endless_socket, asked, lambda: remove_key(path, "headset"))

    asyncio.run(try_it())
    first = door.sent[0]
    if opens:
        assert first == {"type": "websocket.accept"}
    else:
        assert first["status"] == 403
        assert b"foreign-origin" in door.sent[1]["body"]
