"""How the server's clock lies against ours: four stamps, and the quickest of several answers."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from snapfit.clients.python.station import ServerTime


@dataclass(frozen=True)
class TimeOffset:
    """Server time = client time + `offset_us`, at most half of `round_trip_us` off."""

    offset_us: float
    round_trip_us: float

    def server_time_us(self, client_time_us: float) -> int:
        """Our Unix time (microseconds, of `time.time_ns`) by the server's clock."""
        return round(client_time_us + self.offset_us)

    def now_us(self) -> int:
        """Now by the server's clock, microseconds."""
        return self.server_time_us(time.time_ns() / 1000)


class Stopwatch:
    """Stamps a request; its length is measured by the monotonic clock, which nobody sets."""

    def __init__(self) -> None:
        self.sent_at_us = time.time_ns() // 1000
        self._begin_ns = time.perf_counter_ns()

    def offset(self, told: ServerTime) -> TimeOffset:
        """What the answer that just came in tells (docs/conventions.md, Time)."""
        c1 = self.sent_at_us
        c2 = c1 + (time.perf_counter_ns() - self._begin_ns) / 1000
        offset_us = ((told.received_at_us - c1) + (told.sent_at_us - c2)) / 2
        return TimeOffset(offset_us, (c2 - c1) - (told.sent_at_us - told.received_at_us))


def best_of(offsets: Sequence[TimeOffset]) -> TimeOffset:
    """That of the shortest round trip: it has the least room for an error."""
    return min(offsets, key=lambda each: each.round_trip_us)
