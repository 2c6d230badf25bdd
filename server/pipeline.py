"""What a worker runs: a source, a tracker, and how a result is drawn. Workers only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame
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


@dataclass(frozen=True)
class Pipeline:
    """An open source and its tracker.

    Attributes:
        draw: draws a result into a copy of its frame's image, (H, W, 3) uint8 BGR.
    """

    source: Source
    tracker: Tracker
    draw: Callable[[Image, TrackingResult], Image]
