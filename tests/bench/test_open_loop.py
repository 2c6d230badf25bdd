"""Percentiles, and whose delay is whose."""

from __future__ import annotations

import math

import pytest
from open_loop import Poll, Rounds, percentile


@pytest.mark.parametrize(
    ("percent", "value"), [(0, 1), (50, 50), (99, 99), (99.5, 100), (100, 100)]
)
def test_a_percentile_is_the_least_value_that_so_many_do_not_exceed(
    percent: float, value: float
) -> None:
    assert percentile(list(range(100, 0, -1)), percent) == value


def test_what_never_came_counts_in_a_percentile() -> None:
    values = [1.0] * 98 + [math.inf] * 2
    assert percentile(values, 98) == 1.0
    assert percentile(values, 99) == math.inf


def test_of_nothing_there_is_no_percentile() -> None:
    with pytest.raises(ValueError, match="no values"):
        percentile([], 50)


def test_a_poll_that_goes_out_in_time_is_all_the_servers() -> None:
    poll = Poll(due_us=1000, free_us=500, sent_us=1000, received_us=4000, captured_us=-20_000)
    assert (poll.late_ms, poll.server_ms, poll.whole_ms, poll.age_ms) == (0, 3, 3, 24)


def test_a_late_generator_is_not_the_servers_delay() -> None:
    poll = Poll(due_us=1000, free_us=500, sent_us=8000, received_us=9000)
    assert (poll.late_ms, poll.server_ms, poll.whole_ms) == (7, 1, 8)


def test_waiting_for_the_answer_before_is_the_servers_delay() -> None:
    # Due at 1 ms, but the server kept the connection until 50 ms; sent 2 ms later, answered in 1.
    poll = Poll(due_us=1000, free_us=50_000, sent_us=52_000, received_us=53_000)
    assert (poll.late_ms, poll.server_ms, poll.whole_ms) == (2, 50, 52)


def test_an_unanswered_poll_took_for_ever() -> None:
    poll = Poll(1000, 1000, 1000, None)
    assert poll.server_ms == poll.whole_ms == poll.age_ms == math.inf


def test_everybody_polls_at_the_rate_and_evenly_staggered() -> None:
    turns = list(Rounds(0, clients=4, rate_hz=50, seconds=2).due(10**9))
    assert len(turns) == 4 * 50 * 2
    assert [place for place, _ in turns[:6]] == [0, 1, 2, 3, 0, 1]
    assert [due_us for place, due_us in turns if place == 1][:3] == [5000, 25_000, 45_000]


def test_a_turn_is_due_at_its_time_whatever_happened_before() -> None:
    rounds = Rounds(1000, clients=2, rate_hz=100, seconds=1)
    assert list(rounds.due(999)) == []
    assert list(rounds.due(6000)) == [(0, 1000), (1, 6000)]
    # The generator slept through three turns: they are late, and not left out.
    assert list(rounds.due(21_500)) == [(0, 11_000), (1, 16_000), (0, 21_000)]
    assert rounds.next_us == 26_000
