"""What the worker tells of the markers that the camera sees."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from snapfit.server.boards import Board


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SeenMarker(_Message):
    """A board in a frame.

    Attributes:
        board: which.
        position, orientation: `camera_from_marker`, OpenCV's axes.
        error_px: of its corners' reprojection.
        corners: how many were seen.
    """

    board: Board
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    error_px: float
    corners: int


class MarkerMessage(_Message):
    """All boards that were wanted and seen in a frame."""

    boot_id: str
    captured_at_us: int
    seen: tuple[SeenMarker, ...]
