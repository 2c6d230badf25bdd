"""One server for all tests of a folder that do it no harm: not for each, and not for longer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from harness import Server, running

STALE_AFTER_S = 20


class FolderServer:
    """It starts when the first test asks for it, and ends after the folder's last one.

    A fixture for the whole session would go on beside the tests of all other folders: a tenth of
    a core for each server. Poses are stale only if the worker is down, not if it is held up for
    half a second.
    """

    def __init__(self, folder: Path, fault: str = "") -> None:
        self._folder, self._fault = folder, fault
        self._server: Server | None = None
        self._open = ExitStack()

    def started(self) -> Server:
        if self._server is None:
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv("SNAPFIT_STATION__STALE_AFTER_S", str(STALE_AFTER_S))
                self._server = self._open.enter_context(running(self._fault))
        return self._server.wait_ready()

    @pytest.hookimpl(wrapper=True)
    def ends_with(self, nextitem: pytest.Item | None) -> Iterator[None]:
        """A conftest's `pytest_runtest_teardown`: the server ends if what follows is elsewhere."""
        try:
            yield
        finally:
            if nextitem is None or self._folder not in nextitem.path.parents:
                self._server = None
                self._open.close()
