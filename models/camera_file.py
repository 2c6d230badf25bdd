"""A camera file: the calibration of a camera that brings none, as `snapfit calibrate` writes it."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from snapfit.models.camera import PinholeCamera
from snapfit.models.errors import CameraError
from snapfit.models.validation import describe, field_keys


class CameraFile(BaseModel):
    """What is in a camera file (JSON); unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    width: int = Field(gt=0, le=16384, description="Image width, px.")
    height: int = Field(gt=0, le=16384, description="Image height, px.")
    fx: float = Field(gt=0, description="Focal length along x, px.")
    fy: float = Field(gt=0, description="Focal length along y, px.")
    cx: float = Field(description="Principal point x, px; pixel centres at integers.")
    cy: float = Field(description="Principal point y, px.")
    distortion: tuple[float, ...] = Field(
        default=(), max_length=14, description="k1, k2, p1, p2, k3, ... in OpenCV's order."
    )
    rms_px: float = Field(ge=0, description="Root mean square of the reprojection error, px.")
    images: int = Field(ge=1, description="Images that it was calculated from.")
    date: str = Field(description="When, UTC.")
    board: str = Field(description="The board that was seen.")

    @property
    def camera(self) -> PinholeCamera:
        """The camera once its distortion is undone."""
        return PinholeCamera(self.width, self.height, self.fx, self.fy, self.cx, self.cy)


def read_camera_file(path: Path) -> CameraFile:
    """Reads a camera file.

    Raises:
        CameraError: it is missing, no JSON, or a value is refused; names the file and the key.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CameraError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise CameraError(f"{path}: is not valid JSON: {error}") from error
    try:
        return CameraFile.model_validate(content)
    except ValidationError as error:
        key, problem = describe(error, field_keys(CameraFile))
        raise CameraError(f"{path}: {key}: {problem}" if key else f"{path}: {problem}") from error


def write_camera_file(path: Path, file: CameraFile) -> None:
    """Writes a camera file, whole or not at all.

    Raises:
        CameraError: it cannot be written.
    """
    unfinished = path.with_name(f".{path.name}")
    try:
        unfinished.write_text(file.model_dump_json(indent=1) + "\n", encoding="utf-8")
        unfinished.replace(path)
    except OSError as error:
        raise CameraError(f"{path}: cannot be written: {error.strerror}") from error
