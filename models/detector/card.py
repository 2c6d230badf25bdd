"""`detector.json`: what a detector's ONNX file finds, and how it came to be.

It lies beside `detector.onnx` and is the only thing that the tracking reads of this package.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from snapfit.models.errors import DetectorError
from snapfit.models.pose import Array

ONNX_NAME, CARD_NAME = "detector.onnx", "detector.json"
INT8_NAME = "detector.int8.onnx"
STRIDE = 32

Multiple = Annotated[int, Field(gt=0, le=4096, multiple_of=STRIDE)]
Point = tuple[float, float, float]


class CardClass(BaseModel):
    """A class of the network."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    part: str = Field(description="Name of the part.")
    keypoints_m: Annotated[tuple[Point, ...], Field(min_length=4)] = Field(
        description="The keypoints in the network's order, body frame, metres; at least 4."
    )

    @property
    def points(self) -> Array:
        """(K, 3) m, body frame."""
        return np.array(self.keypoints_m, dtype=np.float64)


class DetectorCard(BaseModel):
    """What `detector.json` holds."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Annotated[Literal[1], Field(description="Version of this format.")] = 1
    asset: str = Field(description="Name of the asset.")
    classes: Annotated[tuple[CardClass, ...], Field(min_length=1)] = Field(
        description="The network's classes in their order."
    )
    input_height_px: Multiple = Field(description="Height of the input, a multiple of 32.")
    input_width_px: Multiple = Field(description="Width of the input, a multiple of 32.")
    opset: Annotated[int | None, Field(description="Of the ONNX file.")] = None
    training: dict[str, Any] = Field(
        default_factory=dict, description="Data, recipe, duration and machine of the training."
    )
    metrics: dict[str, float] = Field(
        default_factory=dict, description="Of the validation images; see docs/detector.md."
    )

    @model_validator(mode="after")
    def _is_whole(self) -> DetectorCard:
        counts = {len(each.keypoints_m) for each in self.classes}
        if len(counts) > 1:
            raise ValueError(f"all classes have as many keypoints, these have {sorted(counts)}")
        names = [each.part for each in self.classes]
        if len(set(names)) < len(names):
            raise ValueError(f"each part is one class, these are {names}")
        if not all(np.isfinite(each.points).all() for each in self.classes):
            raise ValueError("a keypoint is not finite")
        return self

    @property
    def n_keypoints(self) -> int:
        """Keypoints of each class."""
        return len(self.classes[0].keypoints_m)

    @property
    def n_rows(self) -> int:
        """Rows of the network's output: box, classes, keypoints."""
        return 4 + len(self.classes) + 3 * self.n_keypoints


def read_card(path: Path) -> DetectorCard:
    """Reads `detector.json`.

    Raises:
        DetectorError: it is missing or damaged; says which key.
    """
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        problem = f"is missing: it says what the classes and keypoints of {ONNX_NAME} are"
        raise DetectorError(path, problem) from error
    except (OSError, ValueError) as error:
        raise DetectorError(path, f"cannot be read: {error}") from error
    try:
        return DetectorCard.model_validate(record)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"])) or "it"
        raise DetectorError(path, f"{key}: {first['msg']}") from error


def write_card(card: DetectorCard, path: Path) -> None:
    """Writes `detector.json`; keypoints to a ten-millionth of a metre.

    Raises:
        DetectorError: the disk is full, or the folder cannot be written.
    """
    record = card.model_dump(mode="json", exclude_none=True)
    for each in record["classes"]:
        each["keypoints_m"] = np.round(each["keypoints_m"], 7).tolist()
    unfinished = path.with_suffix(".partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        unfinished.replace(path)
    except OSError as error:
        raise DetectorError(path, f"cannot be written: {error}") from error
