"""Limits for machines that have other things to do."""

from __future__ import annotations

import os
from pathlib import Path


def within(seconds: float) -> float:
    """A limit for a machine that does nothing else, made longer by what else this one does."""
    return seconds * (1 + _load() / (os.cpu_count() or 1))


def _load() -> float:
    """How many want to run: lately, at this moment, or as soon as this test waits."""
    beside = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", 0))
    return max(os.getloadavg()[0], _running(), beside)


def _running() -> int:
    counts = Path("/proc/loadavg")
    return int(counts.read_text().split()[3].partition("/")[0]) if counts.exists() else 0
