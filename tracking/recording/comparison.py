"""Compares what is said now with what was said then: bit for bit, and if not, how far off."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from snapfit.models.pose import Pose, rotation_vector
from snapfit.tracking.recording.records import EstimateRecord, pose_of
from snapfit.tracking.recording.replay import Replayed
from snapfit.tracking.result import PartEstimate


@dataclass
class Comparison:
    """What has come out so far.

    Attributes:
        frames: that were tracked now and then.
        unrecorded: frames without images.
        poses: that were compared.
        different: poses that differ by a bit or more; a pose then or now alone counts too.
        first_different: name of the first frame with one.
        largest_m, largest_rad: largest difference of two poses.
        problems: frames that could be tracked then and not now, or the other way round.
    """

    frames: int = 0
    unrecorded: int = 0
    poses: int = 0
    different: int = 0
    first_different: str | None = None
    largest_m: float = 0.0
    largest_rad: float = 0.0
    problems: list[str] = field(default_factory=list)

    @property
    def is_identical(self) -> bool:
        """Whether every frame came out the same, bit for bit."""
        return not self.different and not self.problems

    def add(self, replayed: Replayed) -> None:
        """Compares one frame."""
        record = replayed.record
        if replayed.frame is None:
            self.unrecorded += 1
            return
        if replayed.result is None or record.error is not None:
            if (replayed.result is None) != (record.error is not None):
                told = replayed.error or "can be tracked now"
                self.problems.append(f"frame {record.frame}: {told}")
            return
        self.frames += 1
        now = {each.part: each for each in replayed.result.parts}
        for then in record.parts:
            self._compare(record.frame, then, now.get(then.part))

    def _compare(self, frame: str, then: EstimateRecord, now: PartEstimate | None) -> None:
        before = None if then.camera_from_body is None else pose_of(then.camera_from_body)
        after = None if now is None else now.camera_from_body
        if before is None and after is None:
            return
        self.poses += 1
        if before is not None and after is not None:
            if before.matrix.tobytes() == after.matrix.tobytes():
                return
            self._measure(before, after)
        else:
            self.largest_m = self.largest_rad = math.inf
        self.different += 1
        self.first_different = self.first_different or frame

    def _measure(self, before: Pose, after: Pose) -> None:
        moved_m = float(np.linalg.norm(before.translation - after.translation))
        turned = rotation_vector(before.rotation.T @ after.rotation)
        self.largest_m = max(self.largest_m, moved_m)
        self.largest_rad = max(self.largest_rad, float(np.linalg.norm(turned)))
