"""What a station needs of whoever keeps its worker running."""

from __future__ import annotations

from typing import Protocol

from snapfit.server.supervisor import SupervisorStatus


class Keeper(Protocol):
    """Keeps a worker running, here or elsewhere; see `Supervisor`."""

    @property
    def status(self) -> SupervisorStatus:
        """How the worker does."""

    def start(self) -> None:
        """Begin; returns at once."""

    def close(self) -> None:
        """End; returns when it has ended."""
