"""Sets this process's wall clock back, as an administrator or NTP may."""

from __future__ import annotations

import time

BACK_S = 3600


def step_back() -> None:
    """From now on the wall clock is an hour behind; the monotonic clock goes on."""
    seconds, nanoseconds = time.time, time.time_ns
    time.time = lambda: seconds() - BACK_S
    time.time_ns = lambda: nanoseconds() - BACK_S * 1_000_000_000
