"""What happens at a station, for those who want to be told: a bounded ring of events."""

from __future__ import annotations

import secrets
from collections import deque
from dataclasses import dataclass
from enum import StrEnum
from itertools import takewhile
from typing import Any

import orjson

_KEPT = 1000


class EventKind(StrEnum):
    """What can happen."""

    STATE_CHANGED = "state_changed"
    STEP_FINISHED = "step_finished"
    STEP_UNDONE = "step_undone"
    MISASSEMBLED = "misassembled"
    PART_FOUND = "part_found"
    PART_LOST = "part_lost"
    STALE = "stale"
    RECOVERED = "recovered"
    ANCHOR_DRIFT = "anchor_drift"


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        number: counts from 1.
        kind: what.
        block: as it is sent (server-sent events): id, kind, JSON.
    """

    number: int
    kind: EventKind
    block: bytes


class EventLog:
    """The latest events of a station; old ones make room for new ones.

    Attributes:
        run: names this run of the server in event ids: numbers begin again with the next one.
    """

    def __init__(self, kept: int = _KEPT) -> None:
        self.run = secrets.token_hex(4)
        self._events: deque[Event] = deque(maxlen=kept)
        self._number = 0

    @property
    def latest(self) -> int:
        """The number of the latest event, 0 before the first one."""
        return self._number

    def add(self, kind: EventKind, data: dict[str, Any]) -> None:
        """Note an event."""
        self._number += 1
        head = f"id: {self.event_id(self._number)}\nevent: {kind}\ndata: ".encode()
        self._events.append(Event(self._number, kind, b"%b%b\n\n" % (head, orjson.dumps(data))))

    def after(self, number: int) -> list[Event]:
        """All that is kept of what came after an event, in order."""
        # From the end: whoever listens wants the last one or two of a thousand.
        newer = takewhile(lambda event: event.number > number, reversed(self._events))
        return list(newer)[::-1]

    def event_id(self, number: int) -> str:
        """The id of an event, for Last-Event-ID."""
        return f"{self.run}-{number}"

    def resume(self, last_event_id: str) -> int | None:
        """The number after which a client goes on; None where it missed some for good."""
        run, _, number = last_event_id.strip().rpartition("-")
        if run != self.run or not number.isascii() or not number.isdecimal():
            return None
        known = int(number[:20])
        oldest = self._events[0].number if self._events else self._number + 1
        return known if oldest - 1 <= known <= self._number else None
