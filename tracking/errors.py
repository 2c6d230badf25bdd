"""The errors of the per-frame work. Each says what is wrong, where, and what to do."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.errors import SnapfitError


class FrameError(SnapfitError):
    """One frame that cannot be used: the worker counts it, logs it once, and goes on."""

    def __init__(self, frame: str, problem: str) -> None:
        super().__init__(f"frame {frame}: {problem}")
        self.frame = frame
        self.problem = problem


class SourceError(SnapfitError):
    """A source that cannot deliver any frame."""


class TrackingError(SnapfitError):
    """A tracker that cannot be made or started: unknown method, unknown part, no camera."""


class RecordingError(SnapfitError):
    """A recording (MCAP) that cannot be written or read; names the file."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem
