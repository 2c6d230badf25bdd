"""What the API answers: the contract, version 1.

Metres, seconds, radians; time stamps are integer microseconds of Unix time; quaternions are
unit, order x, y, z, w. Poses are `camera_from_body` in the OpenCV camera frame (x right, y down,
z forward) unless another frame or convention was asked for.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from pydantic import Field

from snapfit.server.conventions import Convention
from snapfit.server.schemas_assembly import AssemblySummary
from snapfit.server.schemas_base import (
    Confidence,
    Covariance,
    Quaternion,
    Schema,
    TimestampUs,
    Vector3,
)
from snapfit.tracking.result import Status


class PartPose(Schema):
    """One part in one snapshot."""

    part: str = Field(description="The part's name in its asset.")
    status: Status = Field(
        description="tracked: seen and followed; inferred: hidden, carried by its link; "
        "predicted: hidden, carried by its motion; searching: not found yet; lost: was found, "
        "is no more. A searching or lost part has neither position nor orientation."
    )
    confidence: Confidence = Field(
        description="0 to 1: how probably the pose is right, ADD(-S) below 10 % of the diameter."
    )
    position: Vector3 | None = Field(description="x, y, z of the body's origin, metres.")
    orientation: Quaternion | None = Field(description="Unit quaternion x, y, z, w.")
    covariance: Covariance | None = Field(
        description="6x6, row-major, of the right perturbation in the body frame: rotation "
        "(rad), then translation (m); null where unknown."
    )
    linear_velocity: Vector3 | None = Field(
        description="m/s of the body's origin, along the axes of `frame`; null until seen twice, "
        "and where it has jumped to where it was found."
    )
    angular_velocity: Vector3 | None = Field(
        description="rad/s, axis times rate, along the axes of `frame`; null with the other."
    )
    linked_to: str | None = Field(description="The part that this one is mounted on, or null.")
    last_seen_at_us: TimestampUs | None = Field(
        description="Exposure of the last frame that this part was tracked in."
    )


class SnapshotHeader(Schema):
    """What every snapshot carries, whatever parts it tells of."""

    station: str
    asset: str | None = Field(
        description="The asset under assembly; null where loose parts are tracked."
    )
    boot_id: str = Field(
        description="Names one run of the station's worker. After a restart it is another one, "
        "and `seq` begins again."
    )
    seq: int = Field(ge=1, description="Grows by one with each snapshot of a boot_id.")
    stale: bool = Field(
        description="The worker is down, or this snapshot is older than the station's "
        "`stale_after_s`: do not rely on it."
    )
    captured_at_us: TimestampUs = Field(description="Exposure of the frame.")
    published_at_us: TimestampUs = Field(description="When the tracker was done with it.")
    frame: str = Field(description="The frame that poses are given in.")
    convention: Convention = Field(description="The axes that everything is given in.")
    at_us: TimestampUs | None = Field(
        default=None,
        description="Only where it was asked for: the time that poses are extrapolated to.",
    )
    at_clamped: bool | None = Field(
        default=None,
        description="Only with `at_us`: whether the time asked for is more than 100 ms from the "
        "exposure, so that poses are given for the nearest time within.",
    )


class PoseSnapshot(SnapshotHeader):
    """The poses of all parts in the latest frame."""

    parts: list[PartPose]
    assembly: AssemblySummary | None = Field(description="Null where nothing follows the assembly.")
    age_us: int = Field(
        description="From the exposure to this answer, microseconds, by the server's clock."
    )


class PartSnapshot(SnapshotHeader):
    """The pose of one part in the latest frame."""

    pose: PartPose
    age_us: int = Field(
        description="From the exposure to this answer, microseconds, by the server's clock."
    )


class CameraInfo(Schema):
    """A camera of a station."""

    name: Literal["color", "depth"]
    width: int = Field(description="px")
    height: int = Field(description="px")
    fx: float = Field(description="Focal length, px.")
    fy: float = Field(description="Focal length, px.")
    cx: float = Field(description="Principal point, px; pixel centres at integers.")
    cy: float = Field(description="Principal point, px; pixel centres at integers.")
    distortion: list[float] = Field(
        description="Coefficients in OpenCV's order; empty: the images are undistorted."
    )
    color_from_camera: list[list[float]] = Field(
        description="4x4, row-major, metres: from this camera's frame to the colour camera's."
    )


class Phase(StrEnum):
    """What a worker is doing."""

    STARTING = "starting"
    RUNNING = "running"
    ENDED = "ended"
    FAILED = "failed"


class StationFacts(Schema):
    """What a worker knows of its station once its source is open."""

    asset: str | None
    source: str = Field(description="The source's name.")
    method: str = Field(description="The tracking method.")
    detector: Literal["none", "geometric", "network"] = Field(
        description="What finds the parts: their shape in the depth image, the asset's network, "
        "or nothing beside the method."
    )
    provider: str | None = Field(
        description="What runs the network: cpu, cuda, ...; null without one."
    )
    frame_rate_hz: float
    parts: list[str] = Field(description="The tracked parts.")
    cameras: list[CameraInfo]


class FindingHealth(Schema):
    """How looking for parts goes, counted since the worker started."""

    looks: int = Field(description="Frames that the detector looked into.")
    failed: int = Field(description="Looks in which it could not work; tracking went on.")
    last_problem: str | None = Field(description="Why, the last time.")
    found: int = Field(description="Poses that it proposed.")
    rejected: dict[str, int] = Field(
        description="Candidates that gave no pose, by reason; docs/finding.md names them."
    )
    started: int = Field(description="How often a part was started where it was found.")
    dropped: int = Field(description="How often one of them turned out to be wrong at once.")
    look_ms: float | None = Field(description="How long the last look took, ms.")


class RecordingHealth(Schema):
    """How recording goes since the worker started."""

    file: str = Field(description="Where it is recorded.")
    frames: int = Field(description="Frames that are written with their images.")
    dropped: int = Field(description="Frames whose images there was no time to write.")
    megabytes: float = Field(description="Written, MB.")
    problem: str | None = Field(
        description="Why recording stopped while tracking goes on; null while it records."
    )


class WorkerReport(Schema):
    """What a worker says of itself, twice a second."""

    boot_id: str
    phase: Phase
    message: str = Field(description="What it is doing, or what went wrong.")
    progress: float | None = Field(default=None, ge=0, le=1, description="Of what it is doing.")
    frames: int = Field(default=0, description="Frames tracked since it started.")
    bad_frames: int = Field(default=0, description="Frames that could not be used, skipped.")
    last_bad_frame: str | None = Field(default=None, description="What was wrong with the last.")
    frame_ms: float | None = Field(
        default=None, description="Tracking time for a frame, median of the last 300, ms."
    )
    finding: FindingHealth | None = None
    recording: RecordingHealth | None = None
    facts: StationFacts | None = None
    asset_folder: str | None = Field(
        default=None, description="Where it left what the API serves of the asset."
    )


class WorkerHealth(Schema):
    """The capture-and-track worker of a station."""

    phase: Phase
    message: str
    progress: float | None
    boot_id: str | None
    pid: int | None = Field(description="Null while it is down.")
    restarts: int = Field(description="How often it was started again.")
    last_exit: str | None = Field(description="How it ended the last time.")
    frames: int
    bad_frames: int
    last_bad_frame: str | None
    frame_ms: float | None
    finding: FindingHealth | None = Field(description="Null where no detector runs.")
    recording: RecordingHealth | None = Field(description="Null where nothing is recorded.")


class StationInfo(Schema):
    """One workbench: cameras and one asset under assembly."""

    station: str
    stale_after_s: float
    stale: bool
    facts: StationFacts | None = Field(description="Null until the worker has opened its source.")
    worker: WorkerHealth


class StationList(Schema):
    """All stations of this server."""

    stations: list[StationInfo]


class ServerTime(Schema):
    """Three stamps of a four-stamp clock synchronisation; the client itself takes the fourth.

    In microseconds, with c1 = client_sent_at_us, and c2 when the answer came in:
    offset = ((received_at_us - c1) + (sent_at_us - c2)) / 2,
    round trip = (c2 - c1) - (sent_at_us - received_at_us).
    """

    client_sent_at_us: int | None = Field(description="As the client gave it (c1), or null.")
    received_at_us: TimestampUs = Field(description="When the server took up the request (t1).")
    sent_at_us: TimestampUs = Field(description="When it sent the answer (t2).")


class GbotPart(Schema):
    """A part as the GBOT authors' own server tells it: metres, degrees, for Unity."""

    classId: str = Field(description="The part's name.")  # noqa: N815 - the old clients' name
    x: float
    y: float = Field(description="Negated: up.")
    z: float
    qx: float = Field(description="Turn about x, degrees; the order is z, x, y.")
    qy: float = Field(description="Turn about y, degrees.")
    qz: float = Field(description="Turn about z, degrees, and 180.")


class Health(Schema):
    """The API process itself."""

    status: Literal["ok", "ready"]
    version: str
