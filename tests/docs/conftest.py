"""One server for all pages whose examples are run."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "server"))

from harness import Server, running, wait_for

START_S = 60


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    with running("finds") as it:
        wait_for(it.answers, START_S)
        wait_for(lambda: it.get("/readyz").status_code == 200, START_S)
        yield it
