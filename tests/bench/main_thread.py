"""What a page's main thread spends on its frames, and beside them, from Chromium's trace."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

_FRAME = "FireAnimationFrame"
_TASK = "RunTask"


@dataclass(frozen=True)
class Spent:
    """Processor time of the main thread.

    Attributes:
        seconds: how long was looked, by the clock, s.
        frames: animation frames in that time.
        frame_ms: mean of the tasks with an animation frame in them: script, style, layout and
            paint of one frame, ms.
        frame_ms_median: their median, ms; the first of them compile and load.
        frame_ms_95: their 95th percentile, ms.
        beside_ms_a_second: all other tasks, such as the news that come in, ms in each second.
    """

    seconds: float
    frames: int
    frame_ms: float
    frame_ms_median: float
    frame_ms_95: float
    beside_ms_a_second: float


def spent(events: Sequence[Mapping[str, Any]]) -> Spent:
    """What the main thread that draws frames has spent.

    Args:
        events: of a trace with `devtools.timeline` and `disabled-by-default-devtools.timeline`;
            times in microseconds: `ts` and `dur` by the clock, `tdur` of the processor.

    Raises:
        ValueError: if there are no frames in it, or no times of the processor.
    """
    fired = [event for event in events if event["name"] == _FRAME]
    if not fired:
        raise ValueError("no animation frame in the trace: is the page in the background?")
    (thread, _), *_ = Counter((event["pid"], event["tid"]) for event in fired).most_common(1)
    at_us = sorted(event["ts"] for event in fired if (event["pid"], event["tid"]) == thread)
    tasks = sorted(
        (event["ts"], event["dur"], event["tdur"])
        for event in events
        if event["name"] == _TASK and (event["pid"], event["tid"]) == thread and "tdur" in event
    )
    if not tasks:
        raise ValueError("no tasks with processor time in the trace")
    with_frame = {bisect_right(tasks, (moment, float("inf"), 0)) - 1 for moment in at_us}
    frames_ms = sorted(tasks[index][2] / 1000 for index in with_frame if index >= 0)
    beside_us = sum(task[2] for index, task in enumerate(tasks) if index not in with_frame)
    seconds = (tasks[-1][0] + tasks[-1][1] - tasks[0][0]) / 1e6
    return Spent(
        seconds=seconds,
        frames=len(frames_ms),
        frame_ms=sum(frames_ms) / len(frames_ms),
        frame_ms_median=median(frames_ms),
        frame_ms_95=frames_ms[min(int(len(frames_ms) * 0.95), len(frames_ms) - 1)],
        beside_ms_a_second=beside_us / 1000 / seconds,
    )
