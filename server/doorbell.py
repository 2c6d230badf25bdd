"""Tells another process that there is something new in the store, by a byte in a pipe.

The worker rings when it has published; the API's event loop hears it and looks. What is new stands
in shared memory, so rings that nobody has heard yet are one.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys

_DRAINED_BYTES = 4096


class Doorbell:
    """Both ends, or one; closed with `close`.

    Args:
        heard: file descriptor at which rings come in; None: they are not heard here.
        rung: at which it is rung; None: it makes no sound.

    Attributes:
        rung: as above; a child process may inherit it.
    """

    def __init__(self, heard: int | None, rung: int | None) -> None:
        self._heard = heard
        self.rung = rung
        for end in (heard, rung):
            if end is not None:
                os.set_blocking(end, False)

    @staticmethod
    def create() -> Doorbell:
        """Both ends; neither on Windows, whose event loop hears no pipes."""
        return Doorbell(None, None) if sys.platform == "win32" else Doorbell(*os.pipe())

    def ring(self) -> None:
        """There is something new. Never waits, and never fails: whoever looks finds it anyway."""
        if self.rung is not None:
            with contextlib.suppress(OSError):  # full of rings; or nobody is there any more
                os.write(self.rung, b"!")

    def listen(self, heard: asyncio.Event) -> bool:
        """Set the event at each ring from now on; False where rings are not heard."""
        if self._heard is None:
            return False
        asyncio.get_running_loop().add_reader(self._heard, self._take, self._heard, heard)
        return True

    def deafen(self) -> None:
        """Set nothing any more."""
        if self._heard is not None:
            asyncio.get_running_loop().remove_reader(self._heard)

    def close(self) -> None:
        """Let go of both ends. Closing twice does nothing."""
        for end in (self._heard, self.rung):
            if end is not None:
                os.close(end)
        self._heard = self.rung = None

    @staticmethod
    def _take(end: int, heard: asyncio.Event) -> None:
        with contextlib.suppress(BlockingIOError):
            os.read(end, _DRAINED_BYTES)
        heard.set()
