"""Limits for machines that have other things to do."""

from __future__ import annotations

import os


def within(seconds: float) -> float:
    """A limit for a machine that does nothing else, made longer by what else this one does."""
    load, cores = os.getloadavg()[0], os.cpu_count() or 1
    return seconds * (1 + load / cores)
