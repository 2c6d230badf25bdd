"""What a method did on a sequence, frame by frame and part by part, and how wrong it was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.benchmark.judge import PoseErrors
from snapfit.tracking.result import PartEstimate, Status

Array = npt.NDArray[np.float64]

STATUSES = tuple(Status)


@dataclass(frozen=True, eq=False)
class Run:
    """What a method did on a sequence: F frames, P parts.

    Attributes:
        asset, condition, method: as in the tables.
        parts: names.
        symmetric: whether each part has a symmetry.
        diameters_m: of each part.
        image_width: px.
        frame_rate_hz: of the sequence.
        is_told_state: whether the method was told the true assembly state of each frame.
        frames: names.
        errors: (F, P, 5) as `PoseErrors.values`; infinite without an estimate.
        nees: (F, P, 3) as `normalised_error`; not a number without a covariance.
        confidences: (F, P) as the method states them, 0 to 1.
        camera_from_body: (F, P, 4, 4) estimates, m; not a number without one.
        statuses: (F, P) index into `STATUSES`.
        visibility: (F, P) true share that is visible; not a number where unknown.
        times_ms: (F,) tracking of the whole frame by the clock, reading of images left out.
        cpu_ms: (F,) the same in time of a core, all threads added up; other processes that want
            to run hardly lengthen it.
        misassembled: (F, P) whether the method reports that a part sits wrong.
        true_states, states: (F,) assembly states, true and reported; "" where unknown.
    """

    asset: str
    condition: str
    method: str
    parts: tuple[str, ...]
    symmetric: npt.NDArray[np.bool_]
    diameters_m: Array
    image_width: int
    frame_rate_hz: float
    is_told_state: bool
    frames: npt.NDArray[np.str_]
    errors: Array
    nees: Array
    confidences: Array
    camera_from_body: Array
    statuses: npt.NDArray[np.int8]
    visibility: Array
    times_ms: Array
    cpu_ms: Array
    misassembled: npt.NDArray[np.bool_]
    true_states: npt.NDArray[np.str_]
    states: npt.NDArray[np.str_]

    def error(self, name: str) -> Array:
        """(F, P) one kind of error, by the name of `PoseErrors`' attribute."""
        errors: Array = self.errors[:, :, list(PoseErrors.__dataclass_fields__).index(name)]
        return errors

    @property
    def has_estimate(self) -> npt.NDArray[np.bool_]:
        """(F, P) whether there is an estimate."""
        return np.isfinite(self.camera_from_body[:, :, 0, 0])

    def is_within(self, share: float) -> npt.NDArray[np.bool_]:
        """(F, P) whether ADD(-S) is below a share of the part's diameter."""
        within: npt.NDArray[np.bool_] = self.error("add_m") < share * self.diameters_m
        return within

    def estimates(self, frame: int) -> tuple[PartEstimate, ...]:
        """The estimates of a frame, for drawing."""
        return tuple(
            PartEstimate(
                name,
                STATUSES[self.statuses[frame, i]],
                float(self.confidences[frame, i]),
                self._pose(frame, i),
            )
            for i, name in enumerate(self.parts)
        )

    def _pose(self, frame: int, part: int) -> Pose | None:
        matrix = self.camera_from_body[frame, part]
        return Pose(matrix) if np.isfinite(matrix[0, 0]) else None
