"""One server for all pages whose examples are run."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "server"))

from folder_server import FolderServer
from harness import Server

SHARED = FolderServer(Path(__file__).parent, "finds")
pytest_runtest_teardown = SHARED.ends_with


@pytest.fixture(scope="module")
def server() -> Server:
    return SHARED.started()
