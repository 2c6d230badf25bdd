"""What the tracker says of a frame: a result, never a bare pose."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError

if TYPE_CHECKING:
    from snapfit.tracking.assembly.estimate import AssemblyEstimate


class Status(StrEnum):
    """Where a part's pose comes from."""

    SEARCHING = "searching"
    TRACKED = "tracked"
    INFERRED = "inferred"
    PREDICTED = "predicted"
    LOST = "lost"


@dataclass(frozen=True, eq=False)
class PartEstimate:
    """One part in one frame.

    Attributes:
        part: the part's name.
        status: where the pose comes from.
        confidence: 0 to 1.
        camera_from_body: the pose in the colour camera's frame; None when searching or lost.
        covariance: (6, 6) of the right perturbation in the body frame, rotation (rad) then
            translation (m); None without a pose.
        visibility: share of the part's contour and surface samples that are unoccluded, 0 to 1.
        linked_to: name of the part that carries it; None where it is free.
    """

    part: str
    status: Status
    confidence: float
    camera_from_body: Pose | None
    covariance: npt.NDArray[np.float64] | None = None
    visibility: float = 0.0
    linked_to: str | None = None


@dataclass(frozen=True, eq=False)
class TrackingResult:
    """All parts in one frame.

    Attributes:
        frame: the frame's name.
        captured_at_ns: time of exposure, integer nanoseconds of Unix time.
        parts: one estimate for each tracked part, in the order of the asset.
        duration_ms: time that tracking took for the whole frame.
        state: the assembly state; None where the method does not judge it.
        assembly: all that is said of the assembly; None likewise.
        left_out: what was wrong with frames of cameras that took no part, where others did.
    """

    frame: str
    captured_at_ns: int
    parts: tuple[PartEstimate, ...]
    duration_ms: float
    state: str | None = None
    assembly: AssemblyEstimate | None = None
    left_out: tuple[FrameError, ...] = ()
