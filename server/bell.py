"""Wakes all who wait for the next piece of news of one kind."""

from __future__ import annotations

import asyncio


class Bell:
    """Rings for all who wait at that moment; of one event loop."""

    def __init__(self) -> None:
        self._waiting: list[asyncio.Future[bool]] = []

    def ring(self) -> None:
        """Wake everybody now, in the order in which they came."""
        woken, self._waiting = self._waiting, []
        for waiter in woken:
            _wake(waiter, True)

    async def wait(self, limit_s: float) -> bool:
        """Until it rings; False if it did not in time."""
        loop = asyncio.get_running_loop()
        waiter: asyncio.Future[bool] = loop.create_future()
        self._waiting.append(waiter)
        # Lighter than `asyncio.timeout`: hundreds wait here, and are woken in a row.
        timer = loop.call_later(max(limit_s, 0.0), _wake, waiter, False)
        try:
            has_rung = await waiter
        except asyncio.CancelledError:
            self._forget(waiter)
            raise
        finally:
            timer.cancel()
        if not has_rung:
            self._forget(waiter)
        return has_rung

    def _forget(self, waiter: asyncio.Future[bool]) -> None:
        if waiter in self._waiting:
            self._waiting.remove(waiter)


def _wake(waiter: asyncio.Future[bool], has_rung: bool) -> None:
    if not waiter.done():
        waiter.set_result(has_rung)
