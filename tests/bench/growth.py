"""Whether a process grows: its memory by minutes."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple


class Memory(NamedTuple):
    """What a process holds at one moment, MB.

    Attributes:
        at_s: when; any clock.
        resident_mb: all that is in memory, pages of mapped files too.
        own_mb: of that what belongs to no file.
    """

    at_s: float
    resident_mb: float
    own_mb: float


def memory_of(pid: int, at_s: float) -> Memory:
    """Of a process, now."""
    fields = dict(
        line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines()
    )
    resident, own = (int(fields[key].split()[0]) / 1024 for key in ("VmRSS", "RssAnon"))
    return Memory(at_s, resident, own)


def by_minute(samples: Sequence[Memory], begin_s: float) -> list[Memory]:
    """The median of each minute that has any samples.

    Args:
        samples: in any order.
        begin_s: of the first minute; what came before it is left out.
    """
    minutes: dict[int, list[Memory]] = {}
    for each in samples:
        if each.at_s >= begin_s:
            minutes.setdefault(int((each.at_s - begin_s) // 60), []).append(each)
    return [
        Memory(begin_s + 60 * minute, *(statistics.median(column) for column in _columns(held)))
        for minute, held in sorted(minutes.items())
    ]


def growth_percent(minutes: Sequence[Memory]) -> float:
    """Of resident memory, from the first of these minutes to the last.

    Raises:
        ValueError: fewer than two.
    """
    _need_two(minutes)
    return 100 * (minutes[-1].resident_mb / minutes[0].resident_mb - 1)


def slope_mb_per_hour(minutes: Sequence[Memory]) -> float:
    """Of resident memory: the median of the slopes between every two minutes (Theil and Sen).

    Raises:
        ValueError: fewer than two.
    """
    _need_two(minutes)
    slopes = [
        (later.resident_mb - earlier.resident_mb) / (later.at_s - earlier.at_s)
        for place, earlier in enumerate(minutes)
        for later in minutes[place + 1 :]
    ]
    return 3600 * statistics.median(slopes)


def _columns(held: Sequence[Memory]) -> tuple[list[float], list[float]]:
    return [each.resident_mb for each in held], [each.own_mb for each in held]


def _need_two(minutes: Sequence[Memory]) -> None:
    if len(minutes) < 2:
        raise ValueError(f"growth needs two minutes, there are {len(minutes)}")
