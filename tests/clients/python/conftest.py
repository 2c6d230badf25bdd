"""One server with a detector for all tests that put it back as they found it."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "server"))

from harness import Server, running, wait_for

from snapfit.clients.python import Client

START_S = 60


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    with running("finds") as it:
        wait_for(it.answers, START_S)
        wait_for(lambda: it.get("/readyz").status_code == 200, START_S)
        yield it


@pytest.fixture(scope="session")
def url(server: Server) -> str:
    return f"http://127.0.0.1:{server.port}"


@pytest.fixture
def client(url: str) -> Iterator[Client]:
    """One that leaves no thread behind."""
    before = set(threading.enumerate())
    with Client(url) as it:
        yield it
    assert set(threading.enumerate()) <= before
