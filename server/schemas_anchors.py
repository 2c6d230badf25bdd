"""Anchors, as a client tells them and as the API answers."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator

from snapfit.server.boards import Board, CharucoBoard
from snapfit.server.conventions import Convention
from snapfit.server.schemas_assembly import PlacedPose
from snapfit.server.schemas_base import Schema, TimestampUs

_FARTHEST_M = 1000.0
_UNIT_TOLERANCE = 0.01

Coordinate = Annotated[float, Field(ge=-_FARTHEST_M, le=_FARTHEST_M, allow_inf_nan=False)]
Component = Annotated[float, Field(ge=-1.1, le=1.1, allow_inf_nan=False)]


class GivenPose(BaseModel):
    """A pose from a client."""

    model_config = ConfigDict(extra="forbid")

    position: tuple[Coordinate, Coordinate, Coordinate] = Field(description="x, y, z, metres.")
    orientation: tuple[Component, Component, Component, Component] = Field(
        description="Unit quaternion x, y, z, w."
    )

    @field_validator("orientation")
    @classmethod
    def _is_unit(
        cls, value: tuple[float, float, float, float]
    ) -> tuple[float, float, float, float]:
        length = math.hypot(*value)
        if abs(length - 1) > _UNIT_TOLERANCE:
            raise ValueError(f"a quaternion x, y, z, w has the length 1, this has {length:.4f}")
        x, y, z, w = (each / length for each in value)
        return x, y, z, w


class AnchorRequest(BaseModel):
    """Where a client sees a board, in its own world."""

    model_config = ConfigDict(extra="forbid")

    world_from_marker: GivenPose = Field(
        description="Pose of the board in the client's world. The board's frame: origin in its "
        "middle; in the convention `opencv` x right, y down, z into it, as it is read; in others "
        "along their axes."
    )
    convention: Convention = Field(
        default=Convention.OPENCV, description="Axes of both the world and the board's frame."
    )
    board: Board = Field(
        default=CharucoBoard(),
        description="What both see; else what `snapfit anchor board` prints.",
    )
    ttl_s: float = Field(
        default=3600.0,
        ge=1,
        le=86400,
        allow_inf_nan=False,
        description="The anchor expires when it is not put again for so long, seconds.",
    )
    restart: bool = Field(
        default=False, description="Forget what was put before: begin to average anew."
    )


class Apart(Schema):
    """How far two poses are apart."""

    translation_m: float
    rotation_rad: float


class AnchorInfo(Schema):
    """How a client's world lies against the station's camera."""

    station: str
    anchor: str
    frame: str = Field(description="What to ask for: `?frame=` of poses and steps.")
    convention: Convention
    board: Board
    aligned: bool = Field(description="Whether client and camera have both seen the board.")
    world_from_camera: PlacedPose | None = Field(description="Null until then.")
    samples: int = Field(description="How many of the client's poses are averaged, at most 20.")
    residual: Apart = Field(description="Their root mean square around the average.")
    camera_samples: int = Field(description="How many of the camera's poses are averaged.")
    camera_residual: Apart | None = Field(description="Likewise; null until it has seen the board.")
    camera_error_px: float | None = Field(description="Reprojection error of the board's corners.")
    seen_at_us: TimestampUs | None = Field(description="When the camera saw it last.")
    drift: Apart | None = Field(
        description="Between where the client and the camera see the board now, at the board."
    )
    drifting: bool = Field(description="Whether that is more than 10 mm or 2 degrees.")
    updated_at_us: TimestampUs
    expires_at_us: TimestampUs


class AnchorList(Schema):
    """The anchors of a station."""

    anchors: list[AnchorInfo]
