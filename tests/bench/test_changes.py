"""State changes, and who was told of them when."""

from __future__ import annotations

import math

import pytest
from changes import Change, Told, changes_in, delays_ms

A = Change("mounted", 1_000, 1_010, True)
B = Change("free", 5_000, 5_012, True)


def answer(listener: int, change: Change, received_us: int, captured_us: int | None = None) -> Told:
    """An answer about the assembly, made at the change's first snapshot or at a later one."""
    at_us = change.since_us if captured_us is None else captured_us
    published_us = change.published_us + at_us - change.since_us
    return Told(listener, change.state, change.since_us, received_us, at_us, published_us)


def event(listener: int, state: str, captured_us: int, received_us: int) -> Told:
    return Told(listener, state, captured_us, received_us, captured_us)


def test_a_change_is_published_with_the_first_snapshot_that_shows_it() -> None:
    told = [answer(0, A, 3_000, 2_000), answer(1, A, 1_500), answer(0, B, 5_500)]
    assert changes_in(told, 0, 10_000) == [A, B]


def test_where_nobody_got_that_snapshot_the_exposure_counts() -> None:
    (change,) = changes_in([answer(0, A, 3_000, 2_000)], 0, 10_000)
    assert change == Change("mounted", 1_000, 1_000, False)


def test_changes_outside_the_time_do_not_count() -> None:
    told = [answer(0, A, 1_500), answer(0, B, 5_500)]
    assert changes_in(told, 1_001, 10_000) == [B]
    assert changes_in(told, 0, 5_000) == [A]


def test_each_listener_has_its_own_delay() -> None:
    told = [answer(0, A, 3_010), answer(1, A, 2_010), answer(0, B, 6_012), answer(1, B, 7_012)]
    assert sorted(delays_ms([A, B], told, 2)) == [1, 1, 2, 2]


def test_being_told_twice_the_first_time_counts() -> None:
    told = [answer(0, A, 9_010, 4_000), answer(0, A, 2_010)]
    assert delays_ms([A], told, 1) == [1]


def test_who_was_not_told_waits_for_ever() -> None:
    told = [answer(0, A, 2_010), answer(0, B, 6_012), answer(1, B, 6_012)]
    assert sorted(delays_ms([A, B], told, 3)) == [1, 1, 1, math.inf, math.inf, math.inf]


def test_an_event_belongs_to_the_last_change_before_its_frame() -> None:
    told = [event(0, "mounted", 1_000, 2_010), event(0, "free", 5_300, 9_012)]
    assert sorted(delays_ms([A, B], told, 1)) == [1, 4]


def test_an_event_of_another_state_tells_of_no_change() -> None:
    told = [event(0, "mounted", 5_300, 6_012), event(0, "mounted", 900, 950)]
    assert delays_ms([A, B], told, 1) == [math.inf, math.inf]


def test_more_listeners_than_there_are_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="2 listeners spoke"):
        delays_ms([A], [answer(0, A, 2_000), answer(1, A, 2_000)], 1)
