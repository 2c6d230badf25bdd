"""A small source and tracker for tests of the server: parts that move as written here.

Workers get it by its dotted name; the environment tells what goes wrong:
SCRIPTED_FAULT = bad-frames | nan-pose | refused | crash | end | hang | slow-start | clock-back |
    slow-frames (from the tenth on; no asset)
and what else is to happen:
    assembles (other states by itself, every third of a second; then the cap is found and lost too)
    loose (no asset)
    finds (a detector: all parts are found a third of a second after they are looked for)
    frame-by-frame (a tracker that keeps nothing)
    marker (an ArUco marker is seen)
    camera (a live camera, see scripted_camera)
    sways (it is seen, and parts go to and fro instead of away)
While there is the file that SCRIPTED_HOLD names, nothing that is looked for is found.
Where the station shall record, it does; with `loose` or `slow-frames`, because its asset lies in
no folder.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from drawn_boards import draw_board
from scripted_assembly import STATES, STEPS, ScriptedJudge
from scripted_camera import open_camera
from wall_clock import step_back

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import AZURE_KINECT_720P, PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.server.boards import ArucoMarker
from snapfit.server.pipeline import Image, Pipeline, Report
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.errors import FrameError, SourceError
from snapfit.tracking.finding.account import FindingAccount, LookAccount
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.sources.base import Source

FRAME_RATE_HZ = 30.0
PART_NAMES = ("base", "jaw", "bolt", "knob", "pin", "pad", "rail", "cap")
LOST_PART = "cap"
X_VELOCITY_M_PER_S = 0.1
CAMERA = RgbdCamera(AZURE_KINECT_720P.scaled(0.25), depth=PinholeCamera(64, 48, 50, 50, 32, 24))
END_AFTER_FRAMES = 10
SLOW_FRAME_S = 1.7
FRAMES_A_STATE = 10
FRAMES_TO_FIND = 20
MARKER = ArucoMarker(kind="aruco", id=7, size_m=0.25)
CAMERA_FROM_MARKER = Pose.from_rotation_translation(
    Pose.exp([0.6, 0.5, 0.3, 0, 0, 0]).rotation, (0.02, 0.01, 0.5)
)
CLASS_IDS = {name: 7 + place for place, name in enumerate(PART_NAMES)}


def _triangle() -> Mesh:
    vertices = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], dtype=np.float32)
    return Mesh(vertices, np.array([[0, 1, 2]], dtype=np.int32))


def scripted_parts() -> tuple[Part, ...]:
    return tuple(Part(name, _triangle(), class_id=CLASS_IDS[name]) for name in PART_NAMES)


def scripted_asset(parts: tuple[Part, ...]) -> Asset:
    return Asset("scripted-asset", "Scripted", "Apache-2.0", Path(), parts, STATES, STEPS)


class ScriptedSource:
    """Grey frames with their number; bad ones where asked for."""

    name = "scripted"
    camera = CAMERA
    frame_rate_hz = FRAME_RATE_HZ

    def __init__(self, fault: str) -> None:
        self.parts = scripted_parts()
        self.asset = None if fault in ("loose", "slow-frames") else scripted_asset(self.parts)
        self.initial_poses: Mapping[str, Pose] = {name: Pose.identity() for name in PART_NAMES}
        self._fault = fault
        self._number = 0

    def read(self) -> Frame | None:
        self._number += 1
        if self._fault == "end" and self._number > END_AFTER_FRAMES:
            return None
        if self._fault == "crash" and self._number > END_AFTER_FRAMES:
            raise RuntimeError("a bug in a source")
        if self._fault == "hang" and self._number > END_AFTER_FRAMES:
            time.sleep(60)
        if self._fault == "slow-frames" and self._number > END_AFTER_FRAMES:
            time.sleep(SLOW_FRAME_S)
        if self._fault == "clock-back" and self._number == END_AFTER_FRAMES:
            step_back()
        if self._fault == "bad-frames" and self._number % 3 == 0:
            raise FrameError(f"{self._number:06d}", "the depth image is missing")
        color = np.full((180, 320, 3), self._number % 256, dtype=np.uint8)
        if self._fault in {"marker", "sways"}:
            color = draw_board(MARKER, CAMERA.color, CAMERA_FROM_MARKER)
        return Frame(f"{self._number:06d}", 0, color)

    def close(self) -> None:
        """Nothing to let go of."""


class ScriptedTracker:
    """All parts go along x at a constant speed; one is lost."""

    def __init__(self, fault: str) -> None:
        self._fault = fault
        self._start_ns: int | None = None
        self._searched = dict.fromkeys(PART_NAMES, FRAMES_TO_FIND) if fault == "finds" else {}
        self._judge = ScriptedJudge(FRAMES_A_STATE if fault == "assembles" else 0)

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        assert set(camera_from_body) == set(PART_NAMES)
        self._start_ns = frame.captured_at_ns

    def track(self, frame: Frame) -> TrackingResult:
        if self._start_ns is None:
            self._start_ns = frame.captured_at_ns
        elapsed_s = (frame.captured_at_ns - self._start_ns) / 1e9
        estimates = tuple(
            self._estimate(name, place, elapsed_s) for place, name in enumerate(PART_NAMES)
        )
        assembly = None if self._fault in ("loose", "slow-frames") else self._judge.judge()
        state = None if assembly is None else assembly.state
        return TrackingResult(frame.name, frame.captured_at_ns, estimates, 1.0, state, assembly)

    def set_state(self, state: str) -> None:
        self._judge.set_state(state)

    def search(self, part: str) -> None:
        self._searched[part] = FRAMES_TO_FIND

    def _estimate(self, name: str, place: int, elapsed_s: float) -> PartEstimate:
        if self._searched.get(name, 0) > 0:
            self._searched[name] -= not _is_held()
            return PartEstimate(name, Status.SEARCHING, 0.0, None)
        is_shown = self._fault == "assembles" and elapsed_s % 0.6 > 0.3
        if name == LOST_PART and not is_shown:
            return PartEstimate(name, Status.LOST, 0.0, None)
        x_m = 0.1 * place + X_VELOCITY_M_PER_S * elapsed_s
        if self._fault == "sways":
            x_m = 0.06 * place - 0.2 + 0.5 * X_VELOCITY_M_PER_S * math.sin(2 * elapsed_s)
        turn = Pose.exp([0.1 * place, 0.2, 0.3, 0, 0, 0])
        pose = Pose.from_rotation_translation(turn.rotation, (x_m, 0.02, 0.7))
        if self._fault == "nan-pose" and name == "jaw":
            object.__setattr__(pose, "matrix", np.full((4, 4), np.nan))
        covariance = np.diag([1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6]) + 1e-7 * elapsed_s
        parent = "base" if name == "jaw" else None
        return PartEstimate(name, Status.TRACKED, 0.97, pose, covariance, 1.0, parent)


def _is_held() -> bool:
    hold = os.environ.get("SCRIPTED_HOLD")
    return hold is not None and Path(hold).exists()


class ScriptedFinding:
    """Finds whatever the tracker looks for; it counts nothing."""

    account = FindingAccount(LookAccount(), 0, 0)

    def close(self) -> None:
        """Nothing to let go of."""


def open_pipeline(spec: WorkerSpec, report: Report) -> Pipeline:
    fault = os.environ.get("SCRIPTED_FAULT", "")
    if fault == "refused":
        raise SourceError(f"{spec.source}: no such folder")
    if fault == "slow-start":
        # A minute: nobody shall come too late to see it start.
        for share in np.linspace(0, 1, 1201):
            report("generating viewpoint models", float(share))
            time.sleep(0.05)

    def draw(image: Image, result: TrackingResult) -> Image:
        drawn = image.copy()
        drawn[: len(result.parts)] = 255
        return drawn

    tracker = ScriptedTracker(fault)
    # A camera knows no first poses.
    finding = ScriptedFinding() if fault in ("finds", "camera") else None
    controls = None if fault == "frame-by-frame" else tracker
    source: Source = ScriptedSource(fault)
    if fault == "camera":
        source = open_camera(scripted_asset(scripted_parts()))
    pipeline = Pipeline(source, tracker, draw, spec.method, finding=finding, controls=controls)
    if spec.record is None:
        return pipeline
    from snapfit.server.record_station import with_recording  # loads Numba

    return with_recording(pipeline, spec, None, report)
