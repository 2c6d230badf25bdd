"""Markers that a camera and a headset can both see."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

_LARGEST_M = 2.0
_SMALLEST_M = 0.01

Size = Annotated[float, Field(ge=_SMALLEST_M, le=_LARGEST_M, allow_inf_nan=False)]


class MarkerDictionary(StrEnum):
    """OpenCV's dictionaries of ArUco markers that are in use."""

    DICT_4X4_50 = "DICT_4X4_50"
    DICT_5X5_100 = "DICT_5X5_100"
    DICT_6X6_250 = "DICT_6X6_250"
    DICT_APRILTAG_36H11 = "DICT_APRILTAG_36H11"

    @property
    def size(self) -> int:
        """How many markers it has."""
        return _SIZES[self]


_SIZES = {
    MarkerDictionary.DICT_4X4_50: 50,
    MarkerDictionary.DICT_5X5_100: 100,
    MarkerDictionary.DICT_6X6_250: 250,
    MarkerDictionary.DICT_APRILTAG_36H11: 587,
}


class _Board(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class CharucoBoard(_Board):
    """A chessboard with markers; `snapfit anchor board` prints one.

    Its frame: origin in the middle of the board, x right, y down, z into it, as it is read.
    """

    kind: Literal["charuco"] = "charuco"
    columns: int = Field(default=5, ge=3, le=20, description="Squares from left to right.")
    rows: int = Field(default=7, ge=3, le=20, description="Squares from top to bottom.")
    square_m: Size = Field(default=0.035, description="Edge of a square, metres.")
    marker_m: Size = Field(default=0.026, description="Edge of a marker, metres.")
    dictionary: MarkerDictionary = Field(
        default=MarkerDictionary.DICT_5X5_100, description="OpenCV's dictionary of markers."
    )

    @model_validator(mode="after")
    def _fits(self) -> CharucoBoard:
        if self.marker_m >= self.square_m:
            raise ValueError("marker_m must be smaller than square_m: a marker lies in a square")
        markers = self.columns * self.rows // 2
        if markers > self.dictionary.size:
            raise ValueError(f"{self.dictionary} has {self.dictionary.size} markers, not {markers}")
        return self


class ArucoMarker(_Board):
    """One square marker. Its frame: origin in its middle, x right, y down, z into it."""

    kind: Literal["aruco"]
    id: int = Field(ge=0, le=1023, description="In its dictionary.")
    size_m: Size = Field(description="Edge of the black square, metres.")
    dictionary: MarkerDictionary = Field(
        default=MarkerDictionary.DICT_4X4_50, description="OpenCV's dictionary of markers."
    )

    @model_validator(mode="after")
    def _exists(self) -> ArucoMarker:
        if self.id >= self.dictionary.size:
            last = self.dictionary.size - 1
            raise ValueError(f"the markers of {self.dictionary} have ids from 0 to {last}")
        return self


class QrCode(_Board):
    """A QR code. Its frame: origin in its middle, x right, y down, z into it, as it is read."""

    kind: Literal["qr"]
    text: str = Field(min_length=1, max_length=256, description="What it says.")
    size_m: Size = Field(description="Edge of the code without its quiet zone, metres.")


Board = Annotated[CharucoBoard | ArucoMarker | QrCode, Field(discriminator="kind")]
