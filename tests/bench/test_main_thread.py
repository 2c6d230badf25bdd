"""What a page's main thread spends, read from traces."""

from __future__ import annotations

from typing import Any

import pytest
from main_thread import spent

PAGE, OTHER = (1, 10), (2, 20)


def event(name: str, ts: int, thread: tuple[int, int] = PAGE, **times: int) -> dict[str, Any]:
    return {"name": name, "ts": ts, "pid": thread[0], "tid": thread[1], **times}


def task(ts: int, tdur: int, thread: tuple[int, int] = PAGE) -> dict[str, Any]:
    """A task that takes twice as long by the clock as of the processor."""
    return event("RunTask", ts, thread, dur=2 * tdur, tdur=tdur)


def test_tasks_with_a_frame_are_told_from_the_others() -> None:
    events = [
        task(0, 4_000),
        event("FireAnimationFrame", 100),
        task(10_000, 1_000),
        task(20_000, 6_000),
        event("FireAnimationFrame", 21_000),
        task(996_000, 2_000),
    ]
    it = spent(events[::-1])
    assert (it.frames, it.seconds) == (2, 1.0)
    assert (it.frame_ms, it.frame_ms_median, it.frame_ms_95) == (5.0, 5.0, 6.0)
    assert it.beside_ms_a_second == 3.0


def test_two_callbacks_of_one_task_are_one_frame() -> None:
    fired = [event("FireAnimationFrame", at) for at in (100, 200)]
    assert spent([task(0, 4_000), *fired]).frames == 1


def test_other_threads_do_not_count() -> None:
    events = [task(0, 4_000), event("FireAnimationFrame", 100), task(0, 9_000, OTHER)]
    it = spent(events)
    assert (it.frame_ms, it.beside_ms_a_second) == (4.0, 0.0)


def test_a_trace_that_says_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="no animation frame"):
        spent([task(0, 4_000)])
    with pytest.raises(ValueError, match="processor time"):
        spent([event("FireAnimationFrame", 100)])
