"""Which state changes there were, and who was told of each, when.

A change is known by the exposure of the first frame that shows it: every answer about the assembly
carries that as `since_us`, and the event `state_changed` the exposure of the snapshot at which it
was noticed, which is that one or a little later.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple


class Told(NamedTuple):
    """What one listener was told at one moment.

    Attributes:
        listener: its number.
        state: the assembly state.
        since_us: exposure of the first frame in it; of an event: of the frame it names.
        received_us: when it came in, by the server's clock.
        captured_us: exposure of the snapshot that the answer was made from.
        published_us: when that snapshot was published; None where that is not told (events).
    """

    listener: int
    state: str
    since_us: int
    received_us: int
    captured_us: int
    published_us: int | None = None


class Change(NamedTuple):
    """A change of the assembly state.

    Attributes:
        state: the new one.
        since_us: exposure of the first frame in it.
        published_us: when that frame's snapshot was published.
        is_exact: whether somebody was told so; else it is taken for published when it was exposed,
            which makes its delays longer than they were.
    """

    state: str
    since_us: int
    published_us: int
    is_exact: bool


def changes_in(told: Iterable[Told], begin_us: int, end_us: int) -> list[Change]:
    """The changes between two times, from all answers about the assembly, in order."""
    found: dict[int, Change] = {}
    for each in told:
        if each.published_us is None or not begin_us <= each.since_us < end_us:
            continue
        if each.captured_us == each.since_us:
            found[each.since_us] = Change(each.state, each.since_us, each.published_us, True)
        elif each.since_us not in found:
            found[each.since_us] = Change(each.state, each.since_us, each.since_us, False)
    return [found[since_us] for since_us in sorted(found)]


def delays_ms(changes: Sequence[Change], told: Iterable[Told], listeners: int) -> list[float]:
    """From publication to receipt, of each change to each listener; infinite where it never came.

    Args:
        changes: in order.
        told: what the listeners were told, of their kind alone.
        listeners: how many of that kind there are.

    Returns:
        `len(changes) * listeners` values.
    """
    starts = [change.since_us for change in changes]
    first: dict[tuple[int, int], int] = {}
    who: set[int] = set()
    for each in told:
        who.add(each.listener)
        at = bisect.bisect_right(starts, each.since_us) - 1
        if at < 0 or changes[at].state != each.state:
            continue
        key = (at, each.listener)
        first[key] = min(first.get(key, each.received_us), each.received_us)
    if len(who) > listeners:
        raise ValueError(f"{len(who)} listeners spoke, there are {listeners}")
    delays = [
        (received_us - changes[at].published_us) / 1e3 for (at, _), received_us in first.items()
    ]
    return delays + [math.inf] * (len(changes) * listeners - len(delays))
