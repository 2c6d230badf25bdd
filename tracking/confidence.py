"""How much a pose can be believed: what share of the evidence agrees with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
import numpy.typing as npt

from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID
from snapfit.tracking.parameters import LossParameters
from snapfit.tracking.result import Status

LINE_TOLERANCE_PX = 3.0
POINT_TOLERANCE_M = 0.006
_ENOUGH_EVIDENCE = 60
REGION_SHARE = 0.6
"""What agreeing colours count; the rest is depth's."""
_MANY_LINES, _REFUTED = 60, 0.1


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

    def __add__(self, other: Evidence) -> Evidence:
        """What is known of two linked bodies together."""
        return Evidence(
            *(a + b for a, b in zip(astuple(self), astuple(other), strict=True)),
        )

    @property
    def visibility(self) -> float:
        """Share of the samples that are not hidden, 0 to 1."""
        return 1 - self.occluded / self.considered if self.considered else 0.0

    @property
    def confidence(self) -> float:
        """Share of the evidence that agrees, 0 to 1; little evidence counts less.

        Without any measured depth, colour alone reaches 0.6 at most. Depth alone reaches nothing
        where many lines were looked at and none agrees: a plate fits any table top.
        """
        region = self.supporting_lines / max(self.lines, 1)
        depth = self.supporting_points / max(self.visible_points, 1)
        if self.lines >= _MANY_LINES and region < _REFUTED:
            return 0.0
        agreement = REGION_SHARE * region + (1 - REGION_SHARE) * depth
        return agreement * min(1.0, (self.lines + self.points) / _ENOUGH_EVIDENCE)

    def agreement(self, carrier: Evidence | None) -> float:
        """Confidence in a linked body, 0 to 1: what it lacks in evidence its carriers add.

        Of a plate under its arm hardly a line is seen; but the arm says where it is.
        """
        if carrier is None:
            return self.confidence
        lacking = 1 - min(1.0, (self.lines + self.points) / _ENOUGH_EVIDENCE)
        return self.confidence + lacking * carrier.confidence


NO_EVIDENCE = Evidence(0, 0, 0, 0, 0, 0, 0)


def seen_together(evidence: Sequence[Evidence]) -> Evidence:
    """What several cameras know of one body: all adds up, but as visible as in the best of them."""
    if len(evidence) == 1:
        return evidence[0]
    best = max(evidence, key=lambda each: each.visibility, default=NO_EVIDENCE)
    total = sum(evidence, NO_EVIDENCE)
    return replace(total, considered=best.considered, occluded=best.occluded)


class LossJudge:
    """Tells tracked, hidden and lost parts apart, with patience."""

    def __init__(self, n_bodies: int, parameters: LossParameters | None = None) -> None:
        self.parameters = parameters or LossParameters()
        self._contradicted = [0] * n_bodies
        self._doubted = [0] * n_bodies
        self._usual = [0.0] * n_bodies

    def reset(self, body: int) -> None:
        """Forget what was held against a body."""
        self._contradicted[body] = 0
        self._doubted[body] = 0

    def judge(
        self, body: int, evidence: Evidence, *, solved: bool, carrier: Evidence | None = None
    ) -> Status:
        """The status of an active body after a frame.

        A hidden or doubtful part is `inferred` where its links to others that are seen carry it,
        else `predicted`: its pose stays where it was. A failed Newton step is a loss, never a
        success.

        Args:
            body: its index.
            evidence: of the body itself.
            solved: whether the last refinement could be solved.
            carrier: evidence of the bodies that it is linked to and that can be believed, itself
                left out; None if free.
        """
        if not solved:
            return Status.LOST
        if self.is_hidden(evidence):
            # What was refuted before it was hidden stays refuted.
            return self._status(body, self._carried(carrier) or Status.PREDICTED)
        if self._is_doubtful(body, evidence):
            if self._doubted[body] > self.parameters.doubt_frames:
                self._contradicted[body] += 1
            return self._carried(carrier) or self._status(body, Status.PREDICTED)
        if evidence.confidence >= self.parameters.lost_confidence:
            self._contradicted[body] = 0
            return Status.TRACKED
        if (carried := self._carried(carrier)) is not None:
            return carried
        self._contradicted[body] += 1
        return self._status(body, Status.TRACKED)

    def usual(self, body: int) -> float:
        """The confidence of a body's pose when all is well, as it was lately."""
        return self._usual[body]

    def is_hidden(self, evidence: Evidence) -> bool:
        """Whether next to nothing is seen."""
        p = self.parameters
        little = evidence.lines + evidence.points < p.hidden_evidence
        return little or evidence.visibility < p.hidden_visibility

    def is_believed(self, body: int, evidence: Evidence) -> bool:
        """Whether a body is seen, and agrees with what is seen about as well as it usually does."""
        p = self.parameters
        least = max(p.lost_confidence, p.doubt * self._usual[body])
        return not self.is_hidden(evidence) and evidence.confidence >= least

    def _is_doubtful(self, body: int, evidence: Evidence) -> bool:
        """Whether a pose is much worse than usual; learns what is usual.

        What is worse for long becomes the usual, if it is good enough to be believed at all.
        """
        p = self.parameters
        doubtful = evidence.confidence < p.doubt * self._usual[body]
        self._doubted[body] = self._doubted[body] + 1 if doubtful else 0
        believable = self._doubted[body] > p.doubt_frames and evidence.confidence > p.believable
        if doubtful and not believable:
            return True
        rate = p.usual_rate if self._usual[body] else 1.0
        self._usual[body] += rate * (evidence.confidence - self._usual[body])
        return False

    def _status(self, body: int, status: Status) -> Status:
        lost = self._contradicted[body] >= self.parameters.lost_after_frames
        return Status.LOST if lost else status

    def _carried(self, carrier: Evidence | None) -> Status | None:
        """`inferred` where the other bodies of a structure are seen and agree."""
        if carrier is None or carrier.lines + carrier.points < self.parameters.hidden_evidence:
            return None
        return Status.INFERRED if carrier.confidence >= self.parameters.lost_confidence else None
