"""Stations, and the server itself."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from snapfit.clients.python.schema import Schema


class CameraInfo(Schema):
    """A camera: size and intrinsics in px, `color_from_camera` 4x4, row-major, metres."""

    name: Literal["color", "depth"]
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...]
    color_from_camera: tuple[tuple[float, ...], ...]


class Phase(StrEnum):
    """What a worker is doing."""

    STARTING = "starting"
    RUNNING = "running"
    ENDED = "ended"
    FAILED = "failed"


class StationFacts(Schema):
    """What a worker knows of its station once its source is open."""

    asset: str | None
    source: str
    method: str
    detector: Literal["none", "geometric", "network"]
    provider: str | None
    frame_rate_hz: float
    parts: tuple[str, ...]
    cameras: tuple[CameraInfo, ...]


class FindingHealth(Schema):
    """How looking for parts goes, counted since the worker started."""

    looks: int
    failed: int
    last_problem: str | None
    found: int
    rejected: dict[str, int]
    started: int
    dropped: int
    look_ms: float | None


class RecordingHealth(Schema):
    """How recording goes since the worker started."""

    file: str
    frames: int
    dropped: int
    megabytes: float
    problem: str | None


class WorkerHealth(Schema):
    """The capture-and-track worker of a station."""

    phase: Phase
    message: str
    progress: float | None
    boot_id: str | None
    pid: int | None
    restarts: int
    last_exit: str | None
    frames: int
    bad_frames: int
    last_bad_frame: str | None
    frame_ms: float | None
    finding: FindingHealth | None
    recording: RecordingHealth | None


class StationInfo(Schema):
    """One workbench; `facts` are null until its worker has opened the source."""

    station: str
    stale_after_s: float
    stale: bool
    facts: StationFacts | None
    worker: WorkerHealth


class StationList(Schema):
    """All stations of a server."""

    stations: tuple[StationInfo, ...]


class ServerTime(Schema):
    """Three of the four stamps of a clock synchronisation, microseconds."""

    client_sent_at_us: int | None
    received_at_us: int
    sent_at_us: int


class Health(Schema):
    """Whether the server lives (`ok`), or has fresh poses of all stations (`ready`)."""

    status: Literal["ok", "ready"]
    version: str
