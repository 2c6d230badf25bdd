"""Unix time that never jumps: the wall clock read once, advanced by the monotonic clock."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Clock:
    """The time line of one server and its workers.

    The monotonic clock is the same in all processes of a machine, so a worker that is given
    its server's offset stamps frames on its server's time line, whatever happens to the wall
    clock meanwhile.

    Attributes:
        wall_minus_monotonic_ns: offset between the two clocks when the server started.
    """

    wall_minus_monotonic_ns: int

    @staticmethod
    def started_now() -> Clock:
        """A clock that reads the wall clock now, once."""
        return Clock(time.time_ns() - time.monotonic_ns())

    def now_ns(self) -> int:
        """Unix time, integer nanoseconds."""
        return time.monotonic_ns() + self.wall_minus_monotonic_ns

    def now_us(self) -> int:
        """Unix time, integer microseconds: what the API speaks."""
        return self.now_ns() // 1000
