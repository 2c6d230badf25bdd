"""From the tracker's result to the bytes that the API serves; runs in the worker."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

from snapfit.models.pose import Pose, rotation_vector
from snapfit.server.assembly_snapshot import AssemblyWriter
from snapfit.server.clock import Clock
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

_WITHOUT_POSE = (Status.SEARCHING, Status.LOST)
_FASTEST_M_PER_S, _FASTEST_RAD_PER_S = 5.0, 30.0
"""A hand moves parts at 2 m/s and turns them at 15 rad/s."""


@dataclass(frozen=True)
class _Seen:
    """Where a part was, and when."""

    camera_from_body: Pose
    captured_at_ns: int


class SnapshotWriter:
    """Writes one snapshot after the other; remembers what velocities need.

    Args:
        station, asset: names; no asset where loose parts are tracked.
        boot_id: of this run of the worker.
        clock: the server's time line.

    Attributes:
        assembly: writes the assembly in it.
    """

    def __init__(self, *, station: str, asset: str | None, boot_id: str, clock: Clock) -> None:
        self._header = {"station": station, "asset": asset, "boot_id": boot_id}
        self._clock = clock
        self._seq = 0
        self.assembly = AssemblyWriter()
        self._last_pose: dict[str, _Seen] = {}
        self._last_tracked_at_us: dict[str, int] = {}

    def write(self, result: TrackingResult) -> bytes:
        """JSON of a `PoseSnapshot` without its `age_us`, which only the answering API knows.

        Numbers are written in single precision (nine digits). A part whose pose is not finite
        is published as lost.
        """
        self._seq += 1
        parts = [self._part(estimate, result.captured_at_ns) for estimate in result.parts]
        snapshot = {
            **self._header,
            "seq": self._seq,
            "stale": False,
            "captured_at_us": result.captured_at_ns // 1000,
            "published_at_us": self._clock.now_us(),
            "frame": "camera",
            "convention": "opencv",
            "parts": parts,
            "assembly": None
            if result.assembly is None
            else self.assembly.write(result.assembly, result.captured_at_ns // 1000),
        }
        return orjson.dumps(snapshot, option=orjson.OPT_SERIALIZE_NUMPY)

    def _part(self, estimate: PartEstimate, captured_at_ns: int) -> dict[str, Any]:
        pose = estimate.camera_from_body
        status = estimate.status
        confidence = estimate.confidence
        if not math.isfinite(confidence) or (pose is not None and not _is_finite(pose.matrix)):
            status, confidence = Status.LOST, 0.0
        elif pose is None and status not in _WITHOUT_POSE:
            status = Status.LOST
        if status in _WITHOUT_POSE:
            pose = None
        if status is Status.TRACKED:
            self._last_tracked_at_us[estimate.part] = captured_at_ns // 1000
        linear, angular = self._velocities(estimate.part, pose, captured_at_ns)
        covariance = None if pose is None else estimate.covariance
        return {
            "part": estimate.part,
            "status": status,
            "confidence": min(max(confidence, 0.0), 1.0),
            "position": None if pose is None else _single(pose.translation),
            "orientation": None if pose is None else _single(pose.quaternion),
            "covariance": None if covariance is None else _single(covariance),
            "linear_velocity": linear,
            "angular_velocity": angular,
            "linked_to": estimate.linked_to,
            "last_seen_at_us": self._last_tracked_at_us.get(estimate.part),
        }

    def _velocities(
        self, part: str, pose: Pose | None, captured_at_ns: int
    ) -> tuple[npt.NDArray[np.float32] | None, npt.NDArray[np.float32] | None]:
        """m/s and rad/s in the camera frame, by finite differences over the last two frames.

        None of a part that has jumped: it was found elsewhere, and nothing moves so quickly.
        """
        last = self._last_pose.pop(part, None)
        if pose is None:
            return None, None
        self._last_pose[part] = _Seen(pose, captured_at_ns)
        if last is None or captured_at_ns <= last.captured_at_ns:
            return None, None
        period_s = (captured_at_ns - last.captured_at_ns) / 1e9
        moved_m = pose.translation - last.camera_from_body.translation
        turned_rad = rotation_vector(pose.rotation @ last.camera_from_body.rotation.T)
        linear, angular = moved_m / period_s, turned_rad / period_s
        if math.hypot(*linear) > _FASTEST_M_PER_S or math.hypot(*angular) > _FASTEST_RAD_PER_S:
            return None, None
        return _single(linear), _single(angular)


def _is_finite(values: npt.NDArray[np.floating]) -> bool:
    return bool(np.isfinite(values).all())


def _single(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float32] | None:
    """Single precision, row-major and flat; None if it is not finite."""
    flat = np.ascontiguousarray(values, dtype=np.float32).ravel()
    return flat if _is_finite(flat) else None
