"""A load generator: keep-alive connections over raw sockets, in a process of its own.

python load.py PORT CONNECTIONS SECONDS [RATE_HZ]: as fast as it goes, or each connection at a
rate. Prints JSON: requests, failures, seconds, and the latencies' median and 99th percentile, ms.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from dataclasses import dataclass, field
from typing import cast

import uvloop

REQUEST = b"GET /v1/poses HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
END_OF_HEAD = b"\r\n\r\n"
LENGTH = b"content-length: "


@dataclass
class Counts:
    """What all connections have seen."""

    requests: int = 0
    failures: int = 0
    latencies_s: list[float] = field(default_factory=list)


class Connection(asyncio.Protocol):
    """Sends the next request when the last one is answered, and not before its time."""

    def __init__(self, counts: Counts, period_s: float, delay_s: float) -> None:
        self._counts = counts
        self._period_s = period_s
        self._due_s = time.perf_counter() + delay_s
        self._loop = asyncio.get_running_loop()
        self._received = b""
        self._usual_bytes = -1

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.WriteTransport", transport)
        self._schedule()

    def data_received(self, data: bytes) -> None:
        if self._received:
            data = self._received + data
        if len(data) != self._usual_bytes:
            size = response_bytes(data)
            if size == 0 or len(data) < size:
                self._received = data
                return
            self._usual_bytes = size
        self._received = b""
        self._counts.requests += 1
        self._counts.failures += not data.startswith(b"HTTP/1.1 200")
        self._counts.latencies_s.append(time.perf_counter() - self._sent_at_s)
        self._schedule()

    def _schedule(self) -> None:
        if self._period_s == 0:
            self._send()
            return
        now_s = time.perf_counter()
        self._due_s = max(self._due_s + self._period_s, now_s)
        self._loop.call_later(self._due_s - now_s, self._send)

    def _send(self) -> None:
        self._sent_at_s = time.perf_counter()
        self._transport.write(REQUEST)


def response_bytes(data: bytes) -> int:
    """How long the response is that begins here; 0 while its head is not complete."""
    head_end = data.find(END_OF_HEAD)
    if head_end < 0:
        return 0
    at = data.find(LENGTH) + len(LENGTH)
    return head_end + len(END_OF_HEAD) + int(data[at : data.index(b"\r", at)])


async def load(port: int, connections: int, seconds: float, rate_hz: float) -> dict[str, float]:
    counts = Counts()
    loop = asyncio.get_running_loop()
    period_s = 1 / rate_hz if rate_hz else 0.0
    transports = []
    for place in range(connections):
        delay_s = period_s * place / connections
        connection = Connection(counts, period_s, delay_s)
        transport, _ = await loop.create_connection(lambda it=connection: it, "127.0.0.1", port)  # type: ignore[misc]
        transports.append(transport)
    begin_s, before = time.perf_counter(), counts.requests
    await asyncio.sleep(seconds)
    requests, elapsed_s = counts.requests - before, time.perf_counter() - begin_s
    for transport in transports:
        transport.abort()
    latencies_s = sorted(counts.latencies_s)
    return {
        "requests": requests,
        "failures": counts.failures,
        "seconds": elapsed_s,
        "p50_ms": 1e3 * latencies_s[len(latencies_s) // 2],
        "p99_ms": 1e3 * latencies_s[len(latencies_s) * 99 // 100],
    }


if __name__ == "__main__":
    rate = float(sys.argv[4]) if len(sys.argv) > 4 else 0.0
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        result = runner.run(load(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), rate))
    sys.stdout.write(json.dumps(result) + "\n")
