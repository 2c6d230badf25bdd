"""Wakes whoever waits for a station's news: another snapshot, another assembly, an event."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from snapfit.server.bell import Bell
from snapfit.server.doorbell import Doorbell
from snapfit.server.waiting import Tell, Waiting

_PERIOD_S = 0.02
"""The store is looked at this often even if nobody rings: a snapshot becomes stale in silence."""

_DEAF_PERIOD_S = 0.002
"""How often where no doorbell is heard: nobody waits longer than this."""


class Moment(NamedTuple):
    """What a station has to say at some moment: a snapshot, an assembly at some revision."""

    boot_id: str
    seq: int
    stale: bool
    revision: int

    @property
    def assembly(self) -> tuple[str, bool, int]:
        """What of it waits for an assembly ask for."""
        return self.boot_id, self.stale, self.revision


class Watch:
    """Looks for another moment, and wakes those who wait for what is new in it.

    There is a bell for each kind of news: most of those who listen wait for an assembly or an
    event, and a snapshot, of which there are dozens a second, shall cost them nothing.

    Args:
        look: what the station has to say now; None before its first snapshot.
        told: called at each new moment, before anybody is woken.
        latest_event: the number of the latest event.
        doorbell: rung when there is another snapshot; None without one.
    """

    def __init__(
        self,
        look: Callable[[], Moment | None],
        told: Callable[[], None],
        latest_event: Callable[[], int],
        doorbell: Doorbell | None = None,
    ) -> None:
        self._look = look
        self._told = told
        self._latest_event = latest_event
        self._doorbell = doorbell or Doorbell(None, None)
        self._snapshots, self._assemblies, self._events = Bell(), Bell(), Bell()
        self.is_ending = False

    async def run(self) -> None:
        """Until it is cancelled."""
        rung = asyncio.Event()
        period_s = _PERIOD_S if self._doorbell.listen(rung) else _DEAF_PERIOD_S
        last: Moment | None = None
        event = self._latest_event()
        try:
            while True:
                rung.clear()
                last, event = self._look_again(last, event)
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(period_s):
                        await rung.wait()
        finally:
            self._doorbell.deafen()

    def _look_again(self, last: Moment | None, event: int) -> tuple[Moment | None, int]:
        """Wake whoever waits for what came after this moment and this event; what there is now."""
        now = self._look()
        is_new = now != last
        if is_new:
            self._told()
        # Those first who are told seldom.
        latest = self._latest_event()
        if latest != event:
            self._events.ring()
        if is_new:
            if now is None or last is None or now.assembly != last.assembly:
                self._assemblies.ring()
            self._snapshots.ring()
        return now, latest

    def end(self) -> None:
        """Let nobody wait any more: the server ends."""
        self.is_ending = True
        for bell in (self._snapshots, self._assemblies, self._events):
            bell.ring()

    async def change(self, limit_s: float) -> bool:
        """Wait for the next moment; False if none came in time, or the server ends."""
        return await self._ring_of(self._snapshots, limit_s)

    async def event(self, limit_s: float) -> bool:
        """Wait for the next event, likewise."""
        return await self._ring_of(self._events, limit_s)

    async def snapshot_after(self, boot_id: str | None, seq: int, limit_s: float) -> bool:
        """Wait for a snapshot after this one, or for a change of `stale`; False without it.

        Args:
            boot_id, seq: what is known already; without a boot_id any other seq is new.
            limit_s: how long to wait.
        """
        return await _told(partial(self.tell_snapshot_after, boot_id, seq, limit_s))

    async def revision_after(self, boot_id: str | None, revision: int, limit_s: float) -> bool:
        """Wait for a change of the assembly after this one, likewise."""
        return await _told(partial(self.tell_revision_after, boot_id, revision, limit_s))

    def tell_snapshot_after(
        self, boot_id: str | None, seq: int, limit_s: float, tell: Tell
    ) -> Waiting | None:
        """As `snapshot_after`, without a task; None where there is nothing to wait for."""

        def is_later(now: Moment) -> bool:
            return now.seq != seq if boot_id is None else now.seq > seq or now.boot_id != boot_id

        return self._waiting(is_later, self._snapshots, limit_s, tell)

    def tell_revision_after(
        self, boot_id: str | None, revision: int, limit_s: float, tell: Tell
    ) -> Waiting | None:
        """As `revision_after`, likewise."""

        def is_later(now: Moment) -> bool:
            if boot_id is None:
                return now.revision != revision
            return now.revision > revision or now.boot_id != boot_id

        return self._waiting(is_later, self._assemblies, limit_s, tell)

    def _waiting(
        self, is_later: Callable[[Moment], bool], bell: Bell, limit_s: float, tell: Tell
    ) -> Waiting | None:
        begin = self._look()
        if begin is not None and is_later(begin):
            return None

        def ask() -> bool | None:
            if self.is_ending:
                return False
            now = self._look()
            if now is None:
                return None
            turned = begin is not None and now.stale != begin.stale
            return True if turned or is_later(now) else None

        return Waiting(ask, bell, 0.0 if self.is_ending else limit_s, tell)

    async def _ring_of(self, bell: Bell, limit_s: float) -> bool:
        return not self.is_ending and await bell.wait(limit_s) and not self.is_ending


async def _told(begin: Callable[[Tell], Waiting | None]) -> bool:
    """What is told in the end; True where there is nothing to wait for."""
    answer: asyncio.Future[bool] = asyncio.get_running_loop().create_future()

    def tell(is_new: bool) -> None:
        if not answer.done():  # whoever waited may have been cancelled just now
            answer.set_result(is_new)

    waiting = begin(tell)
    if waiting is None:
        return True
    try:
        return await answer
    finally:
        waiting.forget()
