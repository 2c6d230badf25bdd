"""What is kept of an anchor, and of a board that the camera sees: plain values, as they travel."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.alignment import KEPT
from snapfit.server.boards import Board
from snapfit.server.marker_message import SeenMarker
from snapfit.server.rigid import Rigid


class KeptPose(NamedTuple):
    """A `Rigid` in OpenCV's axes: position (3,), metres, and unit quaternion x, y, z, w."""

    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]


KeptPoses = Annotated[tuple[KeptPose, ...], Field(min_length=1, max_length=KEPT)]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class AnchorRecord(_Record):
    """What a client has put.

    Attributes:
        anchor: its name.
        board: that client and camera both see.
        worlds: `world_from_marker`, the latest one last.
        restarts: how often the client began anew.
        updated_at_us, expires_at_us: Unix time, microseconds.
    """

    anchor: str
    board: Board
    worlds: KeptPoses
    restarts: int = 0
    updated_at_us: int
    expires_at_us: int

    def with_world(
        self, board: Board, world: Rigid, *, now_us: int, ttl_s: float, restart: bool
    ) -> AnchorRecord:
        """The client has put another pose; of another board, or anew, it forgets those before."""
        if restart or board != self.board:
            first = anchor_record(self.anchor, board, world, now_us=now_us, ttl_s=ttl_s)
            return first.model_copy(update={"restarts": self.restarts + 1})
        changes = {
            "worlds": _newest(self.worlds, world),
            "updated_at_us": now_us,
            "expires_at_us": now_us + round(ttl_s * 1e6),
        }
        return self.model_copy(update=changes)


def anchor_record(
    name: str, board: Board, world: Rigid, *, now_us: int, ttl_s: float
) -> AnchorRecord:
    """A new anchor."""
    return AnchorRecord(
        anchor=name,
        board=board,
        worlds=_newest((), world),
        updated_at_us=now_us,
        expires_at_us=now_us + round(ttl_s * 1e6),
    )


class ViewRecord(_Record):
    """How the camera has seen a board.

    Attributes:
        board: which.
        poses: `camera_from_marker`, the latest one last.
        error_px: of its corners' reprojection, in the latest.
        seen_at_us: the latest one's exposure.
    """

    board: Board
    poses: KeptPoses
    error_px: float
    seen_at_us: int


def view_record(before: ViewRecord | None, seen: SeenMarker, captured_at_us: int) -> ViewRecord:
    """The camera has seen a board once more."""
    poses = _newest(() if before is None else before.poses, Rigid(seen.position, seen.orientation))
    return ViewRecord(
        board=seen.board, poses=poses, error_px=seen.error_px, seen_at_us=captured_at_us
    )


def _newest(poses: tuple[KeptPose, ...], another: Rigid) -> tuple[KeptPose, ...]:
    x, y, z = another.position
    a, b, c, w = another.orientation
    return (*poses, KeptPose((x, y, z), (a, b, c, w)))[-KEPT:]
