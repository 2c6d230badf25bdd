"""Where a station's anchors are kept: in this process, with a file for its next start."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

from pydantic import BaseModel, ConfigDict, ValidationError

from snapfit.server.anchor_record import AnchorRecord, ViewRecord
from snapfit.server.board_views import BoardViews
from snapfit.server.boards import Board
from snapfit.server.marker_message import MarkerMessage

_SAVE_PERIOD_S = 1.0
_LOG = logging.getLogger(__name__)

Records = Mapping[str, AnchorRecord]
Change = Callable[[Records], Records]
"""From the anchors that there are to those that there shall be; may be called several times."""


class AnchorShelf(Protocol):
    """Keeps anchors, and how the camera sees their boards."""

    @property
    def records(self) -> Records:
        """By name; another mapping after each change."""

    @property
    def views(self) -> Mapping[Board, ViewRecord]:
        """By board; another mapping after each change."""

    async def change(self, change: Change) -> None:
        """Change the anchors; `records` has them then.

        Raises:
            ProblemError: raised by the change; 503, they cannot be kept now.
        """

    def see(self, message: MarkerMessage) -> None:
        """Take in what a worker of this machine sees."""

    def keep(self, boards: Iterable[Board]) -> None:
        """Forget how other boards were seen."""

    def save(self, *, at_once: bool = False) -> None:
        """Write down what has to be, now and then or at once."""

    def close(self) -> None:
        """Let go of everything."""


class _File(BaseModel):
    """What the file holds: anchors belong to a camera, and another source is another camera."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    source: str
    anchors: tuple[AnchorRecord, ...]


class LocalShelf:
    """Anchors of this process.

    How the camera sees the boards is not written down: while the server was away the camera may
    have been moved, so it has to see them again.

    Args:
        file: where anchors outlive the process; None: they do not.
        source: of the station.
    """

    def __init__(self, file: Path | None = None, source: str = "") -> None:
        self._file = file
        self._source = source
        self._views = BoardViews()
        self._is_due = False
        self._saved_at_s = 0.0
        self.records: Records = {} if file is None else _read(file, source)

    @property
    def views(self) -> Mapping[Board, ViewRecord]:
        """By board."""
        return self._views.records

    async def change(self, change: Change) -> None:
        """Change the anchors.

        Raises:
            ProblemError: raised by the change.
        """
        self.records = change(self.records)
        self._is_due = True
        self.save()

    def see(self, message: MarkerMessage) -> None:
        """Take in what the worker sees."""
        self._views.see(message)

    def keep(self, boards: Iterable[Board]) -> None:
        """Forget how other boards were seen."""
        self._views.keep(boards)

    def save(self, *, at_once: bool = False) -> None:
        """Write the file if something changed, at most once a second."""
        now_s = time.monotonic()
        if not self._is_due or not (at_once or now_s - self._saved_at_s >= _SAVE_PERIOD_S):
            return
        self._is_due = False
        self._saved_at_s = now_s
        if self._file is None:
            return
        try:
            _write(self._file, _File(source=self._source, anchors=tuple(self.records.values())))
        except OSError as error:
            _LOG.warning(
                "%s cannot be written (%s): anchors end with this server; security.keys_file "
                "tells in which folder",
                self._file,
                error.strerror,
            )
            self._file = None

    def close(self) -> None:
        """Write what is not written yet."""
        self.save(at_once=True)


def _read(path: Path, source: str) -> Records:
    try:
        file = _File.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValidationError) as error:
        what = error.strerror if isinstance(error, OSError) else "it is none of this version"
        _LOG.warning("%s cannot be read (%s): anchors begin anew", path, what)
        return {}
    return {it.anchor: it for it in file.anchors} if file.source == source else {}


def _write(path: Path, content: _File) -> None:
    """Whole or not at all; where headsets stood is nobody else's business."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    new = path.with_suffix(".new")
    descriptor = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content.model_dump_json().encode())
    new.replace(path)
