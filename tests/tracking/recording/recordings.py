"""Small recordings: grey frames with their number, one box that goes along x."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry, SymmetryAxis
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.recorder import Recorder
from snapfit.tracking.recording.records import result_fields
from snapfit.tracking.recording.station import loose_meshes, station_record
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CAMERA = RgbdCamera(
    PinholeCamera(64, 48, 60.0, 61.0, 31.5, 23.5),
    PinholeCamera(32, 24, 30.0, 30.5, 15.5, 11.5),
    0.00025,
    Pose.exp([0.001, 0.002, -0.003, 0.015, 0.0, 0.001]),
)
_BOX = trimesh.creation.box((0.04, 0.05, 0.06))
BOX = Part(
    "box",
    Mesh(_BOX.vertices, _BOX.faces),
    (1, 2, 3),
    7,
    Symmetry((Pose.exp([np.pi, 0, 0, 0, 0, 0]),), SymmetryAxis([0, 0, 1], [0.1, 0, 0])),
)
START_NS = 1_700_000_000_123_456_789


class LooseSource:
    """A source whose part belongs to no asset."""

    name, camera, frame_rate_hz = "loose", CAMERA, 25.0
    parts, asset = (BOX,), None
    initial_poses = {"box": Pose.exp([0.3, 0.1, 0.2, 0.01, 0.02, 0.5])}  # noqa: RUF012


def frame(number: int) -> Frame:
    """Noise whose seed is its number."""
    rng = np.random.default_rng(number)
    color = rng.integers(0, 256, (48, 64, 3)).astype(np.uint8)
    depth = rng.integers(0, 65536, (24, 32)).astype(np.uint16)
    return Frame(f"{number:06d}", START_NS + 40_000_000 * number, color, depth)


def pose(number: int) -> Pose:
    return Pose.exp([0.1 * number, -0.2, 1 / 3, 0.01 * number, 1e-17, 0.7])


def result(number: int) -> TrackingResult:
    estimate = PartEstimate("box", Status.TRACKED, 0.9, pose(number), np.eye(6) / 3, 1.0)
    shown = frame(number)
    return TrackingResult(shown.name, shown.captured_at_ns, (estimate,), 1.5)


def begin(path: Path, color_format: str = "png") -> Recorder:
    station = station_record(
        LooseSource(),
        station="bench",
        method="icg",
        detector=None,
        finds=(),
        color_format=color_format,
    )
    return Recorder.begin(path, station, loose_meshes(LooseSource()), START_NS)


def write(path: Path, n_frames: int = 8, color_format: str = "png") -> Path:
    """A recording that was finished."""
    recorder = begin(path, color_format)
    for number in range(n_frames):
        recorder.add(frame(number), [], result_fields(result(number)))
    recorder.log(START_NS, 30, "a line of the log", "snapfit.test")
    recorder.close(limit_s=120)
    assert recorder.account.problem is None
    assert (recorder.account.frames, recorder.account.dropped) == (n_frames, 0)
    return path
