"""Ground truth of a recorded sequence: `gt.jsonl`, one line a frame."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from snapfit.models.errors import SequenceError
from snapfit.models.manifest import PoseField
from snapfit.models.recording import GroundTruth
from snapfit.models.validation import describe, field_keys

TRUTH_NAME = "gt.jsonl"


class TruthRecord(BaseModel):
    """A line of `gt.jsonl`."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )

    frame: str = Field(min_length=1, description="The frame's name.")
    poses: dict[str, PoseField] = Field(description="`camera_from_body` by part, 4x4 by rows.")
    visib: dict[str, float] = Field(default_factory=dict, description="0 to 1, by part.")
    state: str | None = Field(default=None, description="The assembly state.")


def read_truth(path: Path) -> Iterator[GroundTruth]:
    """Yields what is true, frame by frame; nothing where there is no such file.

    Raises:
        SequenceError: a line that is no JSON, has unknown keys or a pose that is no rigid motion.
    """
    if not path.is_file():
        return
    with path.open(encoding="utf-8") as lines:
        for number, line in enumerate(lines, start=1):
            if line.strip():
                yield _parse(path, number, line)


def truth_line(truth: GroundTruth) -> str:
    """One line of `gt.jsonl`, without its end."""
    record = {
        "frame": truth.frame,
        "poses": {name: pose.matrix.tolist() for name, pose in truth.camera_from_body.items()},
        "visib": dict(truth.visibility),
        "state": truth.state,
    }
    return json.dumps(record, allow_nan=False)


def _parse(path: Path, number: int, line: str) -> GroundTruth:
    try:
        record = TruthRecord.model_validate(json.loads(line))
    except ValidationError as error:
        key, problem = describe(error, field_keys(TruthRecord))
        raise SequenceError(path, f"line {number}: {key}: {problem}") from error
    except ValueError as error:
        raise SequenceError(path, f"line {number}: is not valid JSON: {error}") from error
    return GroundTruth(record.frame, record.poses, record.visib, record.state)
