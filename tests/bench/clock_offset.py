"""By how much a server's clock is ahead, from four stamps of each of several exchanges.

A request is received after it was sent, and an answer too: each exchange bounds the offset from
both sides. The bounds of all exchanges together are narrower than those of the quickest one, most
of all on a busy machine, where a way there and the way back take as long as they like.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Exchange(NamedTuple):
    """One request and its answer, microseconds: the first and the last by the client's clock."""

    asked_us: int
    received_us: int
    sent_us: int
    answered_us: int


def clock_ahead_us(exchanges: Sequence[Exchange]) -> tuple[int, int]:
    """The server's clock minus the client's, and by how much that may be wrong.

    Raises:
        ValueError: there is no exchange.
    """
    if not exchanges:
        raise ValueError("no exchange tells nothing of a clock")
    most_us = min(each.received_us - each.asked_us for each in exchanges)
    least_us = max(each.sent_us - each.answered_us for each in exchanges)
    return (most_us + least_us) // 2, (most_us - least_us + 1) // 2
