"""The time line is the wall clock's, whatever holds up the reading of it."""

from __future__ import annotations

from itertools import count

import pytest

from snapfit.server import clock
from snapfit.server.clock import Clock

OFFSET_NS = 1_700_000_000 * 10**9
STEP_NS = 100


class HeldUp:
    """Clocks that take a while to read; one reading of either takes much longer."""

    def __init__(self, slow_reading: int) -> None:
        self._now_ns = 0
        self._readings = count()
        self._slow_reading = slow_reading

    def monotonic_ns(self) -> int:
        slow = next(self._readings) == self._slow_reading
        self._now_ns += 10**9 if slow else STEP_NS
        return self._now_ns

    def time_ns(self) -> int:
        return self.monotonic_ns() + OFFSET_NS


@pytest.mark.parametrize("slow_reading", range(8))
def test_a_hold_up_between_the_readings_shifts_nothing(
    monkeypatch: pytest.MonkeyPatch, slow_reading: int
) -> None:
    monkeypatch.setattr(clock, "time", HeldUp(slow_reading))
    assert abs(Clock.started_now().wall_minus_monotonic_ns - OFFSET_NS) <= STEP_NS
