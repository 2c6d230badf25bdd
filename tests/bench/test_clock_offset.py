"""The offset of two clocks."""

from __future__ import annotations

import pytest
from clock_offset import Exchange, clock_ahead_us

AHEAD_US = 5_000


def exchange(asked_us: int, there_us: int, back_us: int) -> Exchange:
    received_us = asked_us + there_us
    return Exchange(
        asked_us, received_us + AHEAD_US, received_us + 10 + AHEAD_US, received_us + 10 + back_us
    )


def test_a_quick_exchange_tells_the_offset() -> None:
    assert clock_ahead_us([exchange(0, 100, 100)]) == (AHEAD_US, 100)


def test_slow_ways_on_different_sides_bound_it_together() -> None:
    ahead_us, error_us = clock_ahead_us([exchange(0, 40, 20_000), exchange(10**6, 30_000, 60)])
    assert abs(ahead_us - AHEAD_US) <= error_us == 50


def test_the_truth_is_within_what_it_may_be_wrong_by() -> None:
    ahead_us, error_us = clock_ahead_us([exchange(0, 9_000, 1_000), exchange(5, 8_000, 3_000)])
    assert abs(ahead_us - AHEAD_US) <= error_us == 4_500


def test_without_an_exchange_nothing_is_known() -> None:
    with pytest.raises(ValueError, match="no exchange"):
        clock_ahead_us([])
