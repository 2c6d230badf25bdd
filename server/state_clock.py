"""How long each assembly state has held."""

from __future__ import annotations

import time


class StateClock:
    """How long each assembly state has held, as seen by this process."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}
        self._state: str | None = None
        self._since_s = time.monotonic()

    def enter(self, state: str | None) -> None:
        """The state that holds from now on; None while nothing is known."""
        if state == self._state:
            return
        self._seconds = self.seconds()
        self._state, self._since_s = state, time.monotonic()

    def seconds(self) -> dict[str, float]:
        """By state, until now."""
        result = dict(self._seconds)
        if self._state is not None:
            passed_s = time.monotonic() - self._since_s
            result[self._state] = result.get(self._state, 0.0) + passed_s
        return result
