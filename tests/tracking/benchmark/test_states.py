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
