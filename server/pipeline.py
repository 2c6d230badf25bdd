"""What a worker runs: a source, a tracker, and how a result is drawn. Workers only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.finding.account import FindingAccount
from snapfit.tracking.finding.names import DetectorName
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.account import RecordingAccount
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.sources.base import Source

Report = Callable[[str, float | None], None]
"""Told what is being done, and how much of it, 0 to 1, where that is known."""

Image = npt.NDArray[np.uint8]


class Tracker(Protocol):
    """What the worker needs of a tracker; see `snapfit.tracking.methods.create_tracker`."""

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        """Begins with these poses in this frame."""

    def track(self, frame: Frame) -> TrackingResult:
        """Follows the parts into this frame."""


class Finding(Protocol):
    """Looks for parts beside the tracker; see `SelfStartingTracker`."""

    @property
    def account(self) -> FindingAccount:
        """What has become of it so far."""

    def close(self) -> None:
        """Look no more."""


class Controls(Protocol):
    """What an operator can do to a tracker between two frames."""

    def set_state(self, state: str) -> None:
        """Says which assembly state holds.

        Raises:
            TrackingError: it follows no assembly graph, or there is no such state.
        """

    def search(self, part: str) -> None:
        """Lets a part be looked for again, as at the start."""


class Threads(Protocol):
    """Chooses how many threads track; see `KernelThreads`."""

    def tracked(self, duration_ms: float) -> None:
        """Takes note of what a frame took; called in the thread that tracks."""


class Recording(Protocol):
    """Writes down what the worker sees and says; see `Recorder`."""

    @property
    def account(self) -> RecordingAccount:
        """What has become of it so far."""

    def close(self) -> None:
        """Complete the file, in less than a second."""


@dataclass(frozen=True)
class Pipeline:
    """An open source and its tracker.

    Attributes:
        draw: draws a result into a copy of its frame's image, (H, W, 3) uint8 BGR.
        method: its name.
        finding: looks for the parts, which then need no first pose; None where the tracker starts
            from the source's initial poses.
        detector: that it looks with.
        provider: of ONNX Runtime, in short; None without a network.
        controls: what an operator can do; None where every frame is seen by itself.
        recording: of what the tracker gets and says; None where nothing is recorded.
        threads: chooses how many threads track; None where that is as it is.
    """

    source: Source
    tracker: Tracker
    draw: Callable[[Image, TrackingResult], Image]
    method: str
    finding: Finding | None = None
    detector: DetectorName | None = None
    provider: str | None = None
    controls: Controls | None = None
    recording: Recording | None = None
    threads: Threads | None = None

    def close(self) -> None:
        """Let go of threads, files and devices."""
        # First of all: a worker that is told to end has 5 s, and a look may take longer.
        if self.recording is not None:
            self.recording.close()
        if self.finding is not None:
            self.finding.close()
        self.source.close()
