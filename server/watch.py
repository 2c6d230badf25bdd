"""Wakes whoever waits for a station's next snapshot: long polls, streams, the events."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import NamedTuple

_PERIOD_S = 0.004
"""How often the store is looked at. One look costs microseconds; nobody waits longer than this."""


class Moment(NamedTuple):
    """What a station has to say at some moment: a snapshot, an assembly at some revision."""

    boot_id: str
    seq: int
    stale: bool
    revision: int


Count = Callable[[Moment], int]


def by_seq(moment: Moment) -> int:
    """Counts snapshots."""
    return moment.seq


def by_revision(moment: Moment) -> int:
    """Counts changes of the assembly."""
    return moment.revision


class Watch:
    """Looks for another moment, and wakes those who wait for one.

    Args:
        look: what the station has to say now; None before its first snapshot.
        told: called at each new moment, before anybody is woken.
    """

    def __init__(self, look: Callable[[], Moment | None], told: Callable[[], None]) -> None:
        self._look = look
        self._told = told
        self._next = asyncio.Event()
        self.is_ending = False

    async def run(self) -> None:
        """Until it is cancelled."""
        last: Moment | None = None
        while True:
            now = self._look()
            if now != last:
                last = now
                self._told()
                self.wake()
            await asyncio.sleep(_PERIOD_S)

    def wake(self) -> None:
        """Wake everybody now."""
        event, self._next = self._next, asyncio.Event()
        event.set()

    def end(self) -> None:
        """Let nobody wait any more: the server ends."""
        self.is_ending = True
        self.wake()

    async def change(self, limit_s: float) -> bool:
        """Wait for the next moment; False if none came in time, or the server ends."""
        event = self._next
        if self.is_ending:
            return False
        try:
            async with asyncio.timeout(limit_s):
                await event.wait()
        except TimeoutError:
            return False
        return not self.is_ending

    async def newer_than(
        self, boot_id: str | None, number: int, limit_s: float, count: Count = by_seq
    ) -> bool:
        """Wait for something after this, or for a change of `stale`; False without it.

        Args:
            boot_id, number: what is known already; without a boot_id any other number is new.
            limit_s: how long to wait.
            count: what is counted: snapshots, or revisions of the assembly.
        """
        give_up_at_s = time.monotonic() + limit_s
        begin = self._look()
        while True:
            now = self._look()
            if now is not None:
                is_later = count(now) > number or now.boot_id != boot_id
                if boot_id is None:
                    is_later = count(now) != number
                if is_later or (begin is not None and now.stale != begin.stale):
                    return True
            if not await self.change(give_up_at_s - time.monotonic()):
                return False
