"""How much a pose can be believed: what share of the evidence agrees with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID
from snapfit.tracking.result import Status

LINE_TOLERANCE_PX = 3.0
POINT_TOLERANCE_M = 0.006
_ENOUGH_EVIDENCE = 60
_REGION_SHARE = 0.6


@dataclass(frozen=True)
class Evidence:
    """What became of a body's lines and points in one frame.

    Attributes:
        considered: lines and points in the image.
        occluded: those of them that are hidden.
        lines, points: those that took part.
        supporting_lines, supporting_points: those that agree with the final pose.
        visible_points: points in the image that are not hidden.
    """

    considered: int
    occluded: int
    lines: int
    points: int
    supporting_lines: int
    supporting_points: int
    visible_points: int

    @staticmethod
    def of(counts: npt.NDArray[np.int64], support: npt.NDArray[np.int64]) -> Evidence:
        """From the kernels' counts (2, 4) of lines and points, and their support (2,)."""
        return Evidence(
            considered=int(counts[:, CONSIDERED].sum()),
            occluded=int(counts[:, OCCLUDED].sum()),
            lines=int(counts[0, VALID]),
            points=int(counts[1, VALID]),
            supporting_lines=int(support[0]),
            supporting_points=int(support[1]),
            visible_points=int(counts[1, CONSIDERED] - counts[1, OCCLUDED]),
        )

    @property
    def visibility(self) -> float:
        """Share of the samples that are not hidden, 0 to 1."""
        return 1 - self.occluded / self.considered if self.considered else 0.0

    @property
    def confidence(self) -> float:
        """Share of the evidence that agrees, 0 to 1; little evidence counts less.

        Without any measured depth, colour alone reaches 0.6 at most.
        """
        region = self.supporting_lines / max(self.lines, 1)
        depth = self.supporting_points / max(self.visible_points, 1)
        agreement = _REGION_SHARE * region + (1 - _REGION_SHARE) * depth
        return agreement * min(1.0, (self.lines + self.points) / _ENOUGH_EVIDENCE)


@dataclass(frozen=True)
class LossParameters:
    """When a part counts as hidden and when as lost.

    Attributes:
        hidden_evidence: with fewer lines and points than this, a part is hidden.
        lost_confidence: below this the pose contradicts what is seen ...
        lost_after_frames: ... and when it has done so for this long, the part is lost.
    """

    hidden_evidence: int = 20
    lost_confidence: float = 0.15
    lost_after_frames: int = 10


class LossJudge:
    """Tells tracked, hidden and lost parts apart, with patience."""

    def __init__(self, n_bodies: int, parameters: LossParameters | None = None) -> None:
        self.parameters = parameters or LossParameters()
        self._contradicted = [0] * n_bodies

    def reset(self, body: int) -> None:
        """Forget what was held against a body."""
        self._contradicted[body] = 0

    def judge(self, body: int, evidence: Evidence, *, solved: bool) -> Status:
        """The status of an active body after a frame.

        A hidden part is `predicted`: with next to no evidence its pose stays where it was. A
        failed Newton step is a loss, never a success.
        """
        if not solved:
            return Status.LOST
        lost = self._contradicted[body] >= self.parameters.lost_after_frames
        if evidence.lines + evidence.points < self.parameters.hidden_evidence:
            # What was refuted before it was hidden stays refuted.
            return Status.LOST if lost else Status.PREDICTED
        if evidence.confidence < self.parameters.lost_confidence:
            self._contradicted[body] += 1
        else:
            self._contradicted[body] = 0
        lost = self._contradicted[body] >= self.parameters.lost_after_frames
        return Status.LOST if lost else Status.TRACKED
