"""What a worker tells of itself: reports in the store, and each kind of bad frame once."""

from __future__ import annotations

import logging
import statistics
import threading
import time
from collections import deque
from pathlib import Path

from snapfit.server.pose_store import PoseStore
from snapfit.server.schemas import (
    FindingHealth,
    Phase,
    RecordingHealth,
    StationFacts,
    WorkerReport,
)
from snapfit.tracking.finding.account import FindingAccount
from snapfit.tracking.recording.account import RecordingAccount

_PERIOD_S = 0.5
_MEDIAN_OF = 300
_KINDS_REMEMBERED = 1000
_LOG = logging.getLogger(__name__)


class Reporter:
    """Keeps the counts of one run of a worker and publishes them."""

    def __init__(self, store: PoseStore, boot_id: str) -> None:
        self._store = store
        self._report = WorkerReport(boot_id=boot_id, phase=Phase.STARTING, message="starting")
        self._frame_ms: deque[float] = deque(maxlen=_MEDIAN_OF)
        self._kinds: set[str] = set()
        self._published_at_s = 0.0
        self._lock = threading.Lock()  # viewpoint models report from several threads

    def report(self, phase: Phase, message: str, progress: float | None = None) -> None:
        """Say what the worker is doing, at once."""
        self._report.phase = phase
        self._report.message = message
        self._report.progress = None if progress is None else min(max(progress, 0.0), 1.0)
        self._publish()

    def knows(self, facts: StationFacts, asset_folder: Path | None = None) -> None:
        """Say what the station is like, and where the API finds what it serves of the asset."""
        self._report.facts = facts
        self._report.asset_folder = None if asset_folder is None else str(asset_folder)

    def tracked(self, duration_ms: float) -> None:
        """Count a frame; with the first one the worker is running."""
        self._report.frames += 1
        self._frame_ms.append(duration_ms)
        if self._report.phase is Phase.STARTING:
            self.report(Phase.RUNNING, "tracking")

    def bad_frame(self, frame: str, problem: str) -> None:
        """Count a frame that could not be used; log it if its problem is new."""
        self._report.bad_frames += 1
        self._report.last_bad_frame = f"frame {frame}: {problem}"
        if problem not in self._kinds and len(self._kinds) < _KINDS_REMEMBERED:
            self._kinds.add(problem)
            _LOG.warning("frame %s skipped: %s (further ones are only counted)", frame, problem)

    def looked(self, account: FindingAccount) -> None:
        """Say what has become of looking for parts so far."""
        look = account.look
        self._report.finding = FindingHealth(
            looks=look.looks,
            failed=look.failed,
            last_problem=look.last_problem,
            found=look.found,
            rejected=dict(look.rejected),
            started=account.started,
            dropped=account.dropped,
            look_ms=None if look.look_ms is None else round(look.look_ms, 3),
        )

    def recorded(self, account: RecordingAccount) -> None:
        """Say what has become of recording so far."""
        self._report.recording = RecordingHealth(
            file=str(account.path),
            frames=account.frames,
            dropped=account.dropped,
            megabytes=round(account.n_bytes / 1e6, 1),
            problem=account.problem,
        )

    def beat(self) -> None:
        """The loop is alive; publish the counts twice a second."""
        self._store.beat()
        if time.monotonic() - self._published_at_s >= _PERIOD_S:
            self._publish()

    def _publish(self) -> None:
        with self._lock:
            self._published_at_s = time.monotonic()
            if self._frame_ms:
                self._report.frame_ms = round(statistics.median(self._frame_ms), 3)
            self._store.beat()
            self._store.reports.write(self._report.model_dump_json().encode())
