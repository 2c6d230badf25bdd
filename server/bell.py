"""Wakes all who wait for the next piece of news of one kind."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

Wake = Callable[[], None]


class Bell:
    """Rings for all who wait at that moment; of one event loop."""

    def __init__(self) -> None:
        self._waiting: dict[Wake, None] = {}  # in the order in which they came

    def ring(self) -> None:
        """Wake everybody now, in the order in which they came."""
        woken, self._waiting = self._waiting, {}
        for wake in woken:
            wake()

    def call(self, wake: Wake) -> None:
        """Have this called once, when it rings next."""
        self._waiting[wake] = None

    def forget(self, wake: Wake) -> None:
        """Do not call it after all."""
        self._waiting.pop(wake, None)

    async def wait(self, limit_s: float) -> bool:
        """Until it rings; False if it did not in time."""
        loop = asyncio.get_running_loop()
        waiter: asyncio.Future[bool] = loop.create_future()
        wake = partial(_wake, waiter, True)
        self.call(wake)
        # Lighter than `asyncio.timeout`: dozens wait here, and are woken in a row.
        timer = loop.call_later(max(limit_s, 0.0), _wake, waiter, False)
        try:
            return await waiter
        finally:
            timer.cancel()
            self.forget(wake)


def _wake(waiter: asyncio.Future[bool], has_rung: bool) -> None:
    if not waiter.done():
        waiter.set_result(has_rung)
