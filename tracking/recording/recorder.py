"""Writes a recording in a thread of its own; whoever tracks never waits for it."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from snapfit.tracking.errors import RecordingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.account import RecordingAccount
from snapfit.tracking.recording.file import RecordingFile
from snapfit.tracking.recording.records import EventRecord, StationRecord

_LOG = logging.getLogger(__name__)
_MOST_WAITING = 30
"""Frames with their images: 140 MB in 1280x720 with depth."""

_MOST_LINES_WAITING = 1000
_CLOSE_LIMIT_S = 0.7
"""For what waits when a recording is closed: nobody likes to wait for an end."""

_NICER = 5


@dataclass(frozen=True, eq=False)
class _Entry:
    """A frame that waits to be written, or, without a number, a line of the log."""

    fields: Mapping[str, Any]
    frame: Frame | None = None


class Recorder:
    """A recording in the making; all but `close` returns at once.

    Attributes:
        account: what has become of it so far.
    """

    def __init__(self, file: RecordingFile) -> None:
        """Begins to write.

        Args:
            file: written in this recorder's thread alone; closed with it.
        """
        self.account = RecordingAccount(file.path)
        self._file = file
        self._changed = threading.Condition()
        self._waiting: deque[_Entry] = deque()
        self._n_images = self._number = 0
        self._is_closed = False
        self._give_up_at_s = float("inf")
        self._thread = threading.Thread(target=self._run, name="record", daemon=True)
        self._thread.start()

    @classmethod
    def begin(
        cls,
        path: Path,
        station: StationRecord,
        meshes: Mapping[str, bytes],
        time_ns: int,
    ) -> Recorder:
        """Begins a new file.

        Args:
            path: the file; its folder is made.
            station: what is known before the first frame.
            meshes: by part, of loose parts.
            time_ns: now, Unix time.

        Raises:
            RecordingError: the file is there already or cannot be written.
        """
        return cls(RecordingFile(path, station, meshes, time_ns))

    def add(self, frame: Frame, events: list[EventRecord], fields: Mapping[str, Any]) -> None:
        """A frame with what came with it and what was said of it.

        Args:
            frame: its images must not be changed any more.
            events: that came before it was tracked.
            fields: of a `ResultRecord`, beside those that follow from the frame.
        """
        told = {
            "number": self._number,
            "frame": frame.name,
            "captured_at_ns": frame.captured_at_ns,
            "events": [event.model_dump() for event in events],
            **fields,
        }
        self._number += 1
        with self._changed:
            if self._is_closed or self.account.problem is not None:
                return
            is_full = self._n_images >= _MOST_WAITING
            if is_full:
                self._drop()
            else:
                self._n_images += 1
            self._waiting.append(_Entry(told, None if is_full else frame))
            self._changed.notify()

    def log(self, time_ns: int, level: int, text: str, name: str) -> None:
        """A line of the log; `level` is Python's."""
        fields = {"time_ns": time_ns, "level": level, "text": text, "name": name}
        with self._changed:
            if self._is_closed or len(self._waiting) >= _MOST_LINES_WAITING:
                return
            self._waiting.append(_Entry({"log": fields}))
            self._changed.notify()

    def close(self, limit_s: float = _CLOSE_LIMIT_S) -> None:
        """Writes what waits, as far as there is time for it, and completes the file.

        Args:
            limit_s: images that are not written by then are dropped.
        """
        with self._changed:
            self._is_closed = True
            self._give_up_at_s = time.monotonic() + limit_s
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        _be_nice()
        with ThreadPoolExecutor(1, "record-depth", initializer=_be_nice) as beside:
            try:
                self._write_all(beside)
                self._file.finish()
            except OSError as error:
                self._stop(error)
            except Exception as error:  # noqa: BLE001  # a bug here costs a recording, no more
                _LOG.exception("recording failed: a bug")
                self._stop(error)
        self._tell()

    def _write_all(self, beside: ThreadPoolExecutor) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_closed)
                if not self._waiting:
                    return
                entry = self._waiting.popleft()
            self._write(entry, beside)

    def _write(self, entry: _Entry, beside: ThreadPoolExecutor) -> None:
        line = entry.fields.get("log")
        if line is not None:
            self._file.write_log(**line)
            return
        frame = entry.frame
        with self._changed:
            self._n_images -= frame is not None
            if frame is not None and time.monotonic() > self._give_up_at_s:
                frame = None
                self._drop()
        self._file.write_frame(entry.fields, frame, beside)
        self._tell(frames=int(frame is not None))

    def _tell(self, frames: int = 0) -> None:
        """Enter what is written, and so many frames more."""
        with self._changed:
            self.account = replace(
                self.account, frames=self.account.frames + frames, n_bytes=self._file.n_bytes
            )

    def _drop(self) -> None:
        if not self.account.dropped:
            _LOG.warning(
                "recording %s: there is no time to write all frames (further ones are only "
                "counted); JPEG colour takes less",
                self.account.path.name,
            )
        self.account = replace(self.account, dropped=self.account.dropped + 1)

    def _stop(self, error: Exception) -> None:
        """No more is recorded; what was written stays."""
        reason = error.strerror if isinstance(error, OSError) else repr(error)
        problem = f"stopped after {self.account.frames} frames: {reason}"
        with self._changed:
            self._waiting.clear()
            self._n_images = 0
            self.account = replace(self.account, problem=problem)
        self._file.close()
        _LOG.error("recording %s %s; tracking goes on", self.account.path, problem)


def new_path(folder: Path, station: str, time_ns: int) -> Path:
    """Where a station's next recording goes: its name and the time, UTC.

    Raises:
        RecordingError: the folder cannot be made.
    """
    at = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(time_ns // 10**9))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(folder, f"cannot be made: {error.strerror}") from error
    path = folder / f"{station}-{at}.mcap"
    number = 2
    while path.exists():
        path = folder / f"{station}-{at}-{number}.mcap"
        number += 1
    return path


def _be_nice() -> None:
    """Let the tracker go first where the cores are all taken; Linux counts this by thread."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICER)
