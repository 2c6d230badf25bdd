"""One who waits for news without a task of his own: hundreds are told in a row at little cost."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from snapfit.server.bell import Bell

Tell = Callable[[bool], None]
"""Called once: True, the news is here; False, it did not come in time, or never will."""

Ask = Callable[[], bool | None]
"""What there is to tell now; None: nothing yet."""


class Waiting:
    """Asks each time that a bell rings, and tells once, from the event loop.

    Args:
        ask: whether there is something to tell.
        bell: that rings when there may be.
        limit_s: after so long False is told.
        tell: told; never from within the constructor, and never after `forget`.
    """

    def __init__(self, ask: Ask, bell: Bell, limit_s: float, tell: Tell) -> None:
        self._ask = ask
        self._bell = bell
        self._tell = tell
        self._loop = asyncio.get_running_loop()
        self._next: asyncio.Handle = self._loop.call_later(max(limit_s, 0.0), self._too_late)
        bell.call(self._rung)

    def forget(self) -> None:
        """Tell nothing any more; may be called at any time."""
        self._bell.forget(self._rung)
        self._next.cancel()

    def _rung(self) -> None:
        answer = self._ask()
        if answer is None:
            self._bell.call(self._rung)
            return
        self._next.cancel()
        # Not from here: the bell has others to wake, whatever becomes of this one.
        self._next = self._loop.call_soon(self._tell, answer)

    def _too_late(self) -> None:
        self._bell.forget(self._rung)
        self._tell(False)
