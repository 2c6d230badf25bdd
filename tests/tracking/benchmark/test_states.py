import math

import pytest

from snapfit.tracking.benchmark.states import NO_STATES, judge_states

TRUE = ["a"] * 4 + ["b"] * 4 + ["c"] * 4


def test_a_perfect_report_has_no_delay() -> None:
    score = judge_states(TRUE, TRUE)
    assert (score.accuracy, score.delay_frames) == (1.0, 0.0)
    assert (score.n_switches, score.n_missed) == (2, 0)


@pytest.mark.parametrize("delay", [-2, -1, 1, 3])
def test_a_late_report_is_positive_an_early_one_negative(delay: int) -> None:
    reported = [TRUE[min(max(f - delay, 0), 11)] for f in range(12)]
    score = judge_states(TRUE, reported)
    assert score.delay_frames == delay
    assert score.n_missed == 0
    assert score.accuracy == pytest.approx(1 - 2 * abs(delay) / 12)


def test_a_switch_that_is_not_noticed_before_the_next_is_missed() -> None:
    score = judge_states(TRUE, ["a"] * 9 + ["c"] * 3)
    assert (score.n_switches, score.n_missed) == (2, 1)
    assert score.delay_frames == 1.0
    assert score.accuracy == 7 / 12


def test_frames_without_truth_are_not_judged() -> None:
    score = judge_states(["", "", "a", "b"], ["b", "b", "a", "b"])
    assert (score.accuracy, score.n_switches) == (1.0, 1)


def test_who_says_nothing_has_no_figures() -> None:
    for score in (judge_states(TRUE, [""] * 12), judge_states([""] * 12, TRUE)):
        assert score is NO_STATES
        assert math.isnan(score.accuracy)


LONG = ["a"] * 40 + ["b"] * 40
"""One switch, in frame 40."""


@pytest.mark.parametrize(
    ("reported", "found", "settled"),
    [
        (["a"] * 50 + ["b"] * 30, 1, 1.0),
        (["a"] * 30 + ["b"] * 50, 1, 1.0),
        # Frames 30 to 50 are near; 51 is the first that counts, of 30 before and 29 after.
        (["a"] * 52 + ["b"] * 28, 0, 58 / 59),
        (["a"] * 29 + ["b"] * 51, 0, 58 / 59),
        (["a"] * 80, 0, 30 / 59),
    ],
)
def test_a_switch_is_found_within_ten_frames_and_these_are_not_settled(
    reported: list[str], found: int, settled: float
) -> None:
    score = judge_states(LONG, reported)
    assert (score.n_switches, score.n_found) == (1, found)
    assert score.settled_accuracy == pytest.approx(settled)


def test_flicker_is_counted() -> None:
    reported = ["a"] * 40 + ["b", "a", "b", "a"] + ["b"] * 36
    score = judge_states(LONG, reported)
    assert (score.n_found, score.n_reported, score.settled_accuracy) == (1, 5, 1.0)
    assert score.accuracy == 78 / 80


def test_without_a_switch_every_frame_is_settled() -> None:
    score = judge_states(["a"] * 4, ["a", "a", "b", "b"])
    assert (score.settled_accuracy, score.n_switches, score.n_reported) == (0.5, 0, 1)
    assert math.isnan(score.delay_frames)


def test_near_a_switch_alone_there_is_nothing_settled() -> None:
    assert math.isnan(judge_states(TRUE, TRUE).settled_accuracy)
