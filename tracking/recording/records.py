"""What snapfit itself writes into a recording, beside Foxglove's types: JSON, checked on reading.

Numbers are written so that reading gives the same bits.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import Found
from snapfit.tracking.result import PartEstimate, TrackingResult

STATION_TOPIC = "/snapfit/station"
RESULT_TOPIC = "/snapfit/result"
COLOR_TOPIC, DEPTH_TOPIC = "/camera/color", "/camera/depth"
CALIBRATION_TOPICS = {"color": "/camera/color/calibration", "depth": "/camera/depth/calibration"}
TRANSFORMS_TOPIC, LOG_TOPIC = "/tf", "/log"
COLOR_FRAME, DEPTH_FRAME = "camera", "depth_camera"

ColorFormat = Literal["png", "jpeg"]
Matrix = list[list[float]]


def pose_topic(part: str) -> str:
    """The topic of a part's poses."""
    return f"/parts/{part}/pose"


class Record(BaseModel):
    """Base of all records: what is not written here is not in a recording."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class BuildRecord(Record):
    """What must be the same for a replay to give the same bits."""

    snapfit: str = Field(description="Commit of the checkout, or version of the package.")
    code: str = Field(description="Digest of the tracking code and of all that it imports of ours.")
    libraries: str = Field(description="Operating system, Python, NumPy, Numba.")
    cpu: str
    threads: int = Field(description="That the tracker's kernels are spread over.")


class PartRecord(Record):
    """A part, and of loose parts all that there is to know of them."""

    name: str
    mesh: str = Field(description="Digest of its mesh.")
    color_rgb: tuple[int, int, int]
    class_id: int
    motions: list[Matrix] = Field(description="Discrete symmetries.")
    axis: tuple[list[float], list[float]] | None = Field(
        description="Direction and point (m) of the axis of symmetry."
    )


class LensRecord(Record):
    """An undistorted camera; see `PinholeCamera`."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


class StationRecord(Record):
    """What was known before the first frame."""

    version: Literal[1] = 1
    station: str
    source: str
    asset: str | None = Field(description="Name of a bundled asset, or a folder; null: no asset.")
    parts: list[PartRecord]
    method: str | None = Field(description="Null where nothing was tracked.")
    detector: str | None
    finds: list[str] = Field(description="Names of the parts that the detector looks for.")
    frame_rate_hz: float
    color: LensRecord
    depth: LensRecord | None
    depth_scale_m: float
    color_from_depth: Matrix
    initial_poses: dict[str, Matrix]
    color_format: ColorFormat
    build: BuildRecord


class HypothesisRecord(Record):
    """Where a part may be."""

    part: str
    camera_from_body: Matrix
    score: float
    is_refined: bool


class EventRecord(Record):
    """What came to the tracker beside the frame, before this frame was tracked.

    Attributes:
        kind: "start", "caught_up": `poses`. "found": the finder's answer, of an earlier frame.
            "set_state", "stop": the `name` of a state or a part.
    """

    kind: Literal["start", "caught_up", "found", "set_state", "stop"]
    poses: dict[str, Matrix] = {}
    frame: str = ""
    hypotheses: list[HypothesisRecord] = []
    duration_ms: float = 0.0
    problem: str | None = None
    name: str = ""


class EstimateRecord(Record):
    """One part in one frame; see `PartEstimate`."""

    part: str
    status: str
    confidence: float | None
    camera_from_body: Matrix | None
    covariance: list[list[float | None]] | None
    visibility: float | None
    linked_to: str | None


class ResultRecord(Record):
    """One frame, what came with it, and what was said of it."""

    number: int = Field(ge=0, description="Counts the frames that came, recorded or not.")
    frame: str
    captured_at_ns: int
    has_images: bool = Field(description="False where there was no time to write them.")
    events: list[EventRecord] = []
    parts: list[EstimateRecord] = []
    state: str | None = None
    duration_ms: float | None = None
    error: str | None = Field(default=None, description="Why the frame could not be tracked.")


def matrix_of(pose: Pose) -> Matrix:
    """A pose as it is written."""
    rows: Matrix = pose.matrix.tolist()
    return rows


def pose_of(matrix: Matrix) -> Pose:
    """The pose that was written, bit for bit."""
    return Pose(np.array(matrix, dtype=np.float64))


def camera_of(record: StationRecord) -> RgbdCamera:
    """The camera of every frame."""
    depth = None if record.depth is None else PinholeCamera(**record.depth.model_dump())
    color = PinholeCamera(**record.color.model_dump())
    return RgbdCamera(color, depth, record.depth_scale_m, pose_of(record.color_from_depth))


def found_event(found: Found) -> EventRecord:
    """A finder's answer as an event."""
    hypotheses = [
        HypothesisRecord(
            part=each.part,
            camera_from_body=matrix_of(each.camera_from_body),
            score=each.score,
            is_refined=each.is_refined,
        )
        for each in found.hypotheses
    ]
    return EventRecord(
        kind="found",
        frame=found.frame,
        hypotheses=hypotheses,
        duration_ms=found.duration_ms,
        problem=found.problem,
    )


def found_of(event: EventRecord) -> Found:
    """The finder's answer that an event tells of."""
    hypotheses = tuple(
        Hypothesis(each.part, pose_of(each.camera_from_body), each.score, each.is_refined)
        for each in event.hypotheses
    )
    return Found(event.frame, hypotheses, event.duration_ms, event.problem)


def result_fields(result: TrackingResult) -> dict[str, Any]:
    """What a result adds to the record of its frame."""
    return {
        "parts": [_estimate(each) for each in result.parts],
        "state": result.state,
        "duration_ms": result.duration_ms,
    }


def error_fields(error: FrameError | Exception) -> dict[str, Any]:
    """What a frame that could not be tracked adds to its record."""
    return {"error": str(error)}


def _estimate(each: PartEstimate) -> dict[str, Any]:
    pose, covariance = each.camera_from_body, each.covariance
    return {
        "part": each.part,
        "status": each.status.value,
        "confidence": each.confidence,
        "camera_from_body": None if pose is None else pose.matrix.tolist(),
        "covariance": None if covariance is None else covariance.tolist(),
        "visibility": each.visibility,
        "linked_to": each.linked_to,
    }
