"""The Unity package compiled once, and a server for the tests that do it no harm."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "server"))
sys.path.insert(0, str(Path(__file__).parent))

from compiler import compile_all, why_not
from folder_server import FolderServer
from harness import Server

SHARED = FolderServer(Path(__file__).parent)
pytest_runtest_teardown = SHARED.ends_with


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of everything compiled; skips the test where C# cannot be compiled."""
    reason = why_not()
    if reason is not None:
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("unity")
    compile_all(folder)
    return folder


@pytest.fixture(scope="module")
def unity_server(compiled: Path) -> Server:
    """One that nobody harms; not started where nothing can ask it."""
    return SHARED.started()
