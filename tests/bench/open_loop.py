"""Polls at fixed times, whatever the server does, and whose delay is whose.

A poll is due at its time. It cannot be sent while the one before is unanswered: that wait is the
server's doing and counts as its delay (else a server that stalls would be asked less, and look
better: coordinated omission). From when it can be sent until it is, the generator itself is late,
because its process had no core or was at another connection: that is counted apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

UNANSWERED_MS = math.inf


class Poll(NamedTuple):
    """One poll, in microseconds of one clock.

    Attributes:
        due_us: when it was to be sent.
        free_us: when the connection was free: the answer before had come in.
        sent_us: when it was sent.
        received_us: when its answer came in; None if none did.
        captured_us: exposure of the poses that the client has by then; None without any.
    """

    due_us: int
    free_us: int
    sent_us: int
    received_us: int | None
    captured_us: int | None = None

    @property
    def late_ms(self) -> float:
        """The generator's own delay."""
        return (self.sent_us - max(self.due_us, self.free_us)) / 1e3

    @property
    def server_ms(self) -> float:
        """From the time it was due to the answer, without the generator's own delay."""
        if self.received_us is None:
            return UNANSWERED_MS
        return (self.received_us - self.due_us) / 1e3 - self.late_ms

    @property
    def whole_ms(self) -> float:
        """The same with it."""
        return math.inf if self.received_us is None else (self.received_us - self.due_us) / 1e3

    @property
    def age_ms(self) -> float:
        """Of the poses when they came in, from their exposure."""
        if self.received_us is None or self.captured_us is None:
            return math.inf
        return (self.received_us - self.captured_us) / 1e3


class Rounds:
    """Who is due when: so many clients at one rate, evenly staggered, for so long.

    Args:
        begin_us: when the first client is due first.
        clients: how many.
        rate_hz: of each.
        seconds: for how long.
    """

    def __init__(self, begin_us: int, clients: int, rate_hz: float, seconds: float) -> None:
        self._begin_us = begin_us
        self._clients = clients
        self._gap_us = 1e6 / rate_hz / clients
        self._turns = round(seconds * rate_hz) * clients
        self._turn = 0

    @property
    def next_us(self) -> int | None:
        """When the next one is due; None at the end."""
        if self._turn == self._turns:
            return None
        return self._begin_us + round(self._turn * self._gap_us)

    def due(self, now_us: int) -> Iterable[tuple[int, int]]:
        """Each turn that is due by now: the client's number, and when it was."""
        while (due_us := self.next_us) is not None and due_us <= now_us:
            client = self._turn % self._clients
            self._turn += 1
            yield client, due_us


def percentile(values: Sequence[float], percent: float) -> float:
    """By nearest rank: the least value that so many percent do not exceed; infinity may be one.

    Raises:
        ValueError: there is no value.
    """
    if not values:
        raise ValueError("no values, no percentile")
    rank = max(math.ceil(percent / 100 * len(values)), 1)
    return sorted(values)[rank - 1]
