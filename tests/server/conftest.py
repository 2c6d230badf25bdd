"""One server for all tests that do it no harm."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
# The fake network.
sys.path.insert(0, str(Path(__file__).parents[1] / "tracking" / "detection"))

from harness import Server, running


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """One that nobody harms."""
    with running() as it:
        yield it.wait_ready()
