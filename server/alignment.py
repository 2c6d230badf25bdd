"""From what a headset and a camera say of one marker to where the camera is in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from snapfit.server import quaternion
from snapfit.server.rigid import Rigid

KEPT = 20
"""How many poses are averaged."""


class Deviation(NamedTuple):
    """How far two poses are apart."""

    translation_m: float
    rotation_rad: float


class MeanPose:
    """The average of the latest poses of one thing that does not move.

    Args:
        poses: the latest one last.
    """

    def __init__(self, poses: Sequence[Rigid] = ()) -> None:
        self._poses = poses

    def __len__(self) -> int:
        return len(self._poses)

    @property
    def latest(self) -> Rigid | None:
        """The last one; None without a pose."""
        return self._poses[-1] if self._poses else None

    @cached_property
    def mean(self) -> Rigid | None:
        """The average; None without a pose."""
        return mean_of(self._poses) if self._poses else None

    def scatter(self) -> Deviation | None:
        """Root mean square of the poses around their average; None without a pose."""
        mean = self.mean
        if mean is None:
            return None
        apart = [deviation(mean, pose) for pose in self._poses]
        return Deviation(
            _rms([each.translation_m for each in apart]),
            _rms([each.rotation_rad for each in apart]),
        )


def mean_of(poses: Sequence[Rigid]) -> Rigid:
    """The average of poses that are close to each other: of positions, and of quaternions."""
    count = len(poses)
    first = poses[0].orientation
    position, total = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]
    for pose in poses:
        position = [at + each / count for at, each in zip(position, pose.position, strict=True)]
        # A quaternion and its negative are one rotation.
        dot = sum(a * b for a, b in zip(first, pose.orientation, strict=True))
        sign = 1 if dot >= 0 else -1
        total = [at + sign * each for at, each in zip(total, pose.orientation, strict=True)]
    return Rigid(position, quaternion.normalised(total))


def deviation(a: Rigid, b: Rigid) -> Deviation:
    """How far two poses of one thing in one frame are apart."""
    turn = quaternion.multiply(quaternion.inverse(a.orientation), b.orientation)
    return Deviation(math.dist(a.position, b.position), math.hypot(*quaternion.log(turn)))


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values))
