"""A lost frame shows."""

from __future__ import annotations

import pytest
from frame_count import FrameCount, behind_ms, frames_lost, rate_hz

FIRST = FrameCount("a", 100, 1_000_000)


def after(frames: int, late_us: int = 0, hz: float = 30) -> FrameCount:
    return FrameCount("a", 100 + frames, 1_000_000 + round(frames * 1e6 / hz) + late_us)


def test_a_tracker_that_keeps_up_loses_nothing() -> None:
    assert rate_hz(FIRST, after(300)) == pytest.approx(30)
    assert behind_ms(FIRST, after(301), 30) == pytest.approx(0, abs=1e-3)
    assert frames_lost(FIRST, after(301), 30) == 0


@pytest.mark.parametrize(
    ("late_us", "lost"), [(0, 0), (20_000, 0), (33_333, 1), (34_000, 1), (100_000, 3)]
)
def test_a_frame_is_lost_once_the_tracker_is_a_frame_behind(late_us: int, lost: int) -> None:
    assert frames_lost(FIRST, after(50, late_us), 30) == lost
    assert behind_ms(FIRST, after(50, late_us), 30) == pytest.approx(late_us / 1e3, abs=1e-3)


def test_many_small_delays_add_up() -> None:
    assert frames_lost(FIRST, after(600, hz=58), 60) == 20


def test_a_worker_that_was_started_anew_cannot_be_counted() -> None:
    with pytest.raises(ValueError, match="started anew"):
        frames_lost(FIRST, FrameCount("b", 200, 2_000_000), 30)


def test_a_tracker_that_stands_still_is_told() -> None:
    with pytest.raises(ValueError, match="no frame"):
        rate_hz(FIRST, FIRST)
