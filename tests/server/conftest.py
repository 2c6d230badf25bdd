"""One server for all tests that do it no harm."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
# The fake network.
sys.path.insert(0, str(Path(__file__).parents[1] / "tracking" / "detection"))

from folder_server import FolderServer
from harness import Server

SHARED = FolderServer(Path(__file__).parent)
pytest_runtest_teardown = SHARED.ends_with


@pytest.fixture(scope="module")
def server() -> Server:
    """One that nobody harms."""
    return SHARED.started()
