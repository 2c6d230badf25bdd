"""Anchors: how a client's world lies against a station's camera."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Annotated, Any, Literal

from pydantic import Field

from snapfit.clients.python.schema import Convention, PlacedPose, Schema


class MarkerDictionary(StrEnum):
    """OpenCV's dictionaries of ArUco markers."""

    DICT_4X4_50 = "DICT_4X4_50"
    DICT_5X5_100 = "DICT_5X5_100"
    DICT_6X6_250 = "DICT_6X6_250"
    DICT_APRILTAG_36H11 = "DICT_APRILTAG_36H11"


class CharucoBoard(Schema):
    """A chessboard with markers; unless told, the one that `snapfit anchor board` prints."""

    kind: Literal["charuco"] = "charuco"
    columns: int = 5
    rows: int = 7
    square_m: float = 0.035
    marker_m: float = 0.026
    dictionary: MarkerDictionary = MarkerDictionary.DICT_5X5_100


class ArucoMarker(Schema):
    """One square marker; `size_m` is the edge of its black square."""

    kind: Literal["aruco"] = "aruco"
    id: int
    size_m: float
    dictionary: MarkerDictionary = MarkerDictionary.DICT_4X4_50


class QrCode(Schema):
    """A QR code that says `text`; `size_m` is its edge without the quiet zone."""

    kind: Literal["qr"] = "qr"
    text: str
    size_m: float


Board = Annotated[CharucoBoard | ArucoMarker | QrCode, Field(discriminator="kind")]


class AnchorRequest(Schema):
    """Where a client sees a board, in its own world."""

    world_from_marker: PlacedPose
    convention: Convention = Convention.OPENCV
    board: Board = CharucoBoard()
    ttl_s: float = 3600.0
    restart: bool = False


def anchor_request(
    position: Sequence[float], orientation: Sequence[float], **more: Any
) -> AnchorRequest:
    """A request.

    Args:
        position: of the board in the client's world, x, y, z, metres.
        orientation: likewise, unit quaternion x, y, z, w.
        more: other fields of `AnchorRequest`.

    Raises:
        ValueError: one of them is not what it must be.
    """
    unknown = set(more) - set(AnchorRequest.model_fields)
    if unknown:
        raise ValueError(f"an anchor has no {', '.join(sorted(unknown))}")
    pose = {"position": tuple(position), "orientation": tuple(orientation)}
    return AnchorRequest.model_validate({**more, "world_from_marker": pose})


class Apart(Schema):
    """How far two poses are apart."""

    translation_m: float
    rotation_rad: float


class AnchorInfo(Schema):
    """An anchor; `frame` is what to ask for in poses and steps, once it is `aligned`."""

    station: str
    anchor: str
    frame: str
    convention: Convention
    board: Board
    aligned: bool
    world_from_camera: PlacedPose | None
    samples: int
    residual: Apart
    camera_samples: int
    camera_residual: Apart | None
    camera_error_px: float | None
    seen_at_us: int | None
    drift: Apart | None
    drifting: bool
    updated_at_us: int
    expires_at_us: int


class AnchorList(Schema):
    """The anchors of a station."""

    anchors: tuple[AnchorInfo, ...]
