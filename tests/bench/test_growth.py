"""Growth of memory, by minutes."""

from __future__ import annotations

import os
import time

import pytest
from growth import Memory, by_minute, growth_percent, memory_of, slope_mb_per_hour


def leaking(mb_per_minute: float, minutes: int = 10) -> list[Memory]:
    times_s = range(0, 60 * minutes, 5)
    return [Memory(t, 400 + mb_per_minute * t / 60, 300.0) for t in times_s]


def test_minutes_are_medians_and_what_came_before_is_left_out() -> None:
    samples = [Memory(0, 900, 1), *(Memory(60 + t, mb, 2) for t, mb in ((0, 5), (1, 6), (2, 90)))]
    samples.append(Memory(130, 7, 3))
    assert by_minute(samples, 60) == [Memory(60, 6, 2), Memory(120, 7, 3)]


def test_a_leak_shows() -> None:
    minutes = by_minute(leaking(1.0), 0)
    assert len(minutes) == 10
    assert growth_percent(minutes) == pytest.approx(100 * 9 / minutes[0].resident_mb)
    assert slope_mb_per_hour(minutes) == pytest.approx(60)


def test_one_minute_that_stands_out_makes_no_slope() -> None:
    minutes = by_minute(leaking(0.0), 0)
    minutes[4] = Memory(minutes[4].at_s, 900, 300)
    assert slope_mb_per_hour(minutes) == 0
    assert growth_percent(minutes) == 0


def test_one_minute_has_no_growth() -> None:
    with pytest.raises(ValueError, match="two minutes"):
        growth_percent(by_minute(leaking(1.0, minutes=1), 0))


def test_memory_of_a_process_grows_with_what_it_holds() -> None:
    before = memory_of(os.getpid(), time.monotonic())
    held = bytearray(os.urandom(1)) * (64 << 20)
    after = memory_of(os.getpid(), time.monotonic())
    assert len(held) == 64 << 20
    assert after.resident_mb - before.resident_mb == pytest.approx(64, abs=8)
    assert after.own_mb - before.own_mb == pytest.approx(64, abs=8)
