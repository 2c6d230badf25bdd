"""Reads server-sent events over a socket of its own."""

from __future__ import annotations

import json
import socket
import threading
import time
from dataclasses import dataclass
from typing import Any

import httpx
from harness import START_LIMIT_S, Server, wait_for


@dataclass(frozen=True)
class Received:
    """An event as it came in."""

    id: str
    kind: str
    data: dict[str, Any]
    at_us: float


class EventClient:
    """Collects events in a thread until it is closed."""

    def __init__(self, server: Server, last_event_id: str | None = None) -> None:
        self.events: list[Received] = []
        self.comments = 0
        self.begin_id = ""
        self.is_open = False
        self._socket: socket.socket | None = None
        self._client = httpx.Client(timeout=60)
        self._headers = {} if last_event_id is None else {"Last-Event-ID": last_event_id}
        self._url = f"http://127.0.0.1:{server.port}/v1/events"
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        wait_for(lambda: self.is_open)

    def kinds(self) -> list[str]:
        return [event.kind for event in self.events]

    def wait_for(self, kind: str, limit_s: float = START_LIMIT_S) -> Received:
        found: Received = wait_for(
            lambda: next((event for event in self.events if event.kind == kind), None), limit_s
        )
        return found

    def close(self) -> None:
        """Leave, as a program does that ends."""
        if self._socket is not None and self._thread.is_alive():
            self._socket.shutdown(socket.SHUT_RDWR)
        self.join()
        self._client.close()

    def join(self) -> None:
        """Until the stream has ended."""
        self._thread.join(60)
        assert not self._thread.is_alive()

    def _run(self) -> None:
        fields: dict[str, str] = {}
        try:
            with self._client.stream("GET", self._url, headers=self._headers) as answer:
                assert answer.headers["content-type"] == "text/event-stream"
                stream = answer.extensions["network_stream"]
                self._socket = stream.get_extra_info("socket")
                for line in answer.iter_lines():
                    self._take(line, fields)
                    self.is_open |= not line  # the server has said where it begins
        except httpx.HTTPError:
            return  # closed

    def _take(self, line: str, fields: dict[str, str]) -> None:
        if line.startswith(":"):
            self.comments += 1
        elif line:
            name, _, value = line.partition(": ")
            fields[name] = value
        else:
            self.begin_id = self.begin_id or fields["id"]
            if "event" in fields:
                data = json.loads(fields["data"])
                at_us = time.time_ns() / 1000
                self.events.append(Received(fields.get("id", ""), fields["event"], data, at_us))
            fields.clear()
