"""Errors of what is known before the first frame: what is wrong, where, and what to do."""

from __future__ import annotations

from pathlib import Path


class SnapfitError(Exception):
    """Base of every error that snapfit raises on purpose; its text is written for the user."""


class PoseError(SnapfitError):
    """A pose that is no rigid motion: not finite, not 4x4, or its rotation not orthonormal."""


class CameraError(SnapfitError):
    """A camera that cannot exist: size, focal length or depth scale not positive or not finite."""


class MeshError(SnapfitError):
    """A mesh that cannot be tracked: missing, empty, not closed where it must be, wrong unit."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class ManifestError(SnapfitError):
    """A manifest (`asset.toml`) that is refused; names the file and the key."""

    def __init__(self, path: Path, key: str, problem: str) -> None:
        super().__init__(f"{path}: {key}: {problem}" if key else f"{path}: {problem}")
        self.path = path
        self.key = key
        self.problem = problem


class SequenceError(SnapfitError):
    """A recorded sequence that cannot be opened; names the file and the key."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class ViewpointModelError(SnapfitError):
    """A viewpoint model that could not be generated or read back."""


class WorkbenchError(SnapfitError):
    """An asset that the simulated workbench cannot put together."""


class PictureError(SnapfitError):
    """A picture or graph that cannot be written; names the file."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class DatasetError(SnapfitError):
    """A dataset that cannot be written or read; names the file."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem

    def __reduce__(self) -> tuple[type[DatasetError], tuple[Path, str]]:
        """It comes back whole from another process."""
        return type(self), (self.path, self.problem)


class TrainingError(SnapfitError):
    """A network that cannot be trained: no such device, another recipe, no loss."""


class DetectorError(SnapfitError):
    """A detector's files that cannot be used; names the file."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class CalibrationError(SnapfitError):
    """A camera that cannot be calibrated from what was seen: too little, or it does not agree."""
