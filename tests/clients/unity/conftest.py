"""The Unity package compiled once, and a server for the tests that do it no harm."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "server"))
sys.path.insert(0, str(Path(__file__).parent))

from compiler import compile_all, why_not
from harness import Server, running


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of everything compiled; skips the test where C# cannot be compiled."""
    reason = why_not()
    if reason is not None:
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("unity")
    compile_all(folder)
    return folder


@pytest.fixture(scope="session")
def unity_server(compiled: Path) -> Iterator[Server]:
    """One that nobody harms; not started where nothing can ask it."""
    with running() as it:
        yield it.wait_ready()
