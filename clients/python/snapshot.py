"""Poses: what a station says of one frame."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from snapfit.clients.python.assembly import AssemblySummary
from snapfit.clients.python.schema import (
    Convention,
    Covariance,
    Matrix4,
    Quaternion,
    Schema,
    Vector3,
    pose_matrix,
)


class Status(StrEnum):
    """What is known of a part; `searching` and `lost` have no pose."""

    SEARCHING = "searching"
    TRACKED = "tracked"
    INFERRED = "inferred"
    PREDICTED = "predicted"
    LOST = "lost"


class Identity(NamedTuple):
    """Which snapshot it is: `seq` counts within one `boot_id`, one run of the worker."""

    boot_id: str
    seq: int


class PartPose(Schema):
    """One part in one snapshot: metres, rad, seconds, along the axes of the snapshot's `frame`.

    Attributes:
        confidence: 0 to 1: how probably the pose is right.
        covariance: 36 numbers, 6x6 row-major, of the right perturbation in the body's frame:
            rotation (rad), then translation (m).
    """

    part: str
    status: Status
    confidence: float
    position: Vector3 | None
    orientation: Quaternion | None
    covariance: Covariance | None
    linear_velocity: Vector3 | None
    angular_velocity: Vector3 | None
    linked_to: str | None
    last_seen_at_us: int | None

    def matrix(self) -> Matrix4 | None:
        """4x4, row-major: maps points of the body into `frame`; None without a pose."""
        if self.position is None or self.orientation is None:
            return None
        return pose_matrix(self.position, self.orientation)


class SnapshotHeader(Schema):
    """What every snapshot carries. Use one only while `stale` is false.

    Attributes:
        captured_at_us: exposure, Unix time by the server's clock, microseconds.
        at_us: the time that poses are extrapolated to, where it was asked for.
        at_clamped: whether that is not the time asked for, which was too far off.
        age_us: from the exposure to when this object was made.
    """

    station: str
    asset: str | None
    boot_id: str
    seq: int
    stale: bool
    captured_at_us: int
    published_at_us: int
    frame: str
    convention: Convention
    at_us: int | None = None
    at_clamped: bool | None = None
    age_us: int

    @property
    def identity(self) -> Identity:
        """Which snapshot it is."""
        return Identity(self.boot_id, self.seq)

    @property
    def version(self) -> tuple[Identity, bool]:
        """Which snapshot it is, and whether it is stale: what its news is."""
        return self.identity, self.stale


class PoseSnapshot(SnapshotHeader):
    """The poses of all parts in the latest frame."""

    parts: tuple[PartPose, ...]
    assembly: AssemblySummary | None

    def part(self, name: str) -> PartPose:
        """One of the parts.

        Raises:
            KeyError: there is none of this name; lists those that there are.
        """
        for part in self.parts:
            if part.part == name:
                return part
        names = ", ".join(part.part for part in self.parts)
        raise KeyError(f"station {self.station} has no part {name!r}; it has {names}")


class PartSnapshot(SnapshotHeader):
    """The pose of one part in the latest frame."""

    pose: PartPose
