"""One server with a detector for all tests that put it back as they found it."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "server"))

from folder_server import FolderServer
from harness import Server
from patience import within

from snapfit.clients.python import Client

SHARED = FolderServer(Path(__file__).parent, "finds")
pytest_runtest_teardown = SHARED.ends_with


@pytest.fixture(scope="module")
def server() -> Server:
    return SHARED.started()


@pytest.fixture(scope="module")
def url(server: Server) -> str:
    return f"http://127.0.0.1:{server.port}"


@pytest.fixture
def client(url: str) -> Iterator[Client]:
    """One that leaves no thread behind."""
    before = set(threading.enumerate())
    with Client(url, timeout_s=within(30)) as it:
        yield it
    assert set(threading.enumerate()) <= before
