"""Plays a recording as a camera would have delivered it."""

from __future__ import annotations

import threading
import time


class Pacer:
    """When frames are exposed: at the frame rate, whatever the tracker does.

    A camera holds the newest frame until it is fetched. So a tracker that is late by less than a
    frame's time gets the frame that waits, and is in time again with the next. One that is later
    has lost frames at a camera; of a recording it gets them all, later by as many whole frames.
    """

    def __init__(self, frame_rate_hz: float) -> None:
        self._period_ns = round(1e9 / frame_rate_hz)
        self._due_ns = time.monotonic_ns()

    def wait(self, stop: threading.Event) -> int:
        """Wait until the next frame has been exposed; when that was, monotonic, ns."""
        self._due_ns += self._period_ns
        now_ns = time.monotonic_ns()
        late_ns = max(now_ns - self._due_ns, 0)
        self._due_ns += late_ns // self._period_ns * self._period_ns
        if self._due_ns > now_ns:
            stop.wait((self._due_ns - now_ns) / 1e9)
        return self._due_ns
