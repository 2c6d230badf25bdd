"""Unix time that never jumps: the wall clock read at the start, advanced by the monotonic clock."""

from __future__ import annotations

import time
from dataclasses import dataclass

_READINGS = 5


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
        """A clock that begins with what the wall clock says now."""
        # Held up between two readings, they are not of one moment: the quickest of a few are.
        return Clock(min(_read_both() for _ in range(_READINGS))[1])

    def now_ns(self) -> int:
        """Unix time, integer nanoseconds."""
        return time.monotonic_ns() + self.wall_minus_monotonic_ns

    def now_us(self) -> int:
        """Unix time, integer microseconds: what the API speaks."""
        return self.now_ns() // 1000


def _read_both() -> tuple[int, int]:
    """How long the readings took, and the offset between the clocks; nanoseconds."""
    before_ns = time.monotonic_ns()
    wall_ns = time.time_ns()
    took_ns = time.monotonic_ns() - before_ns
    return took_ns, wall_ns - before_ns - took_ns // 2
