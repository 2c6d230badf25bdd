"""What can be said of bodies after a frame: evidence, status, confidence, pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.confidence import NO_EVIDENCE, Evidence, LossJudge
from snapfit.tracking.following import GraphFollower
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.recovery.seen_through import SeenThrough
from snapfit.tracking.result import PartEstimate, Status


class Assessment:
    """Assesses the bodies of one optimiser, frame after frame.

    Args:
        names: of the bodies, in order.
        optimiser: that has refined their poses.
        judge: tells hidden and lost parts from tracked ones.
        seen_through: compares poses with the depth image.
        refutes: whether a pose that the depth camera sees through has no evidence.
        graph: that links the parts; None where they are free.

    Attributes:
        agreements: by body, the share of evidence that agreed with its last pose, 0 to 1.
    """

    def __init__(
        self,
        names: Sequence[str],
        optimiser: Optimiser,
        judge: LossJudge,
        seen_through: SeenThrough,
        *,
        refutes: bool,
        graph: GraphFollower | None,
    ) -> None:
        self.agreements = [0.0] * len(names)
        self._names, self._optimiser, self._judge = names, optimiser, judge
        self._seen_through, self._refutes = seen_through, refutes
        self._graph = graph

    def estimates(
        self, predicted: npt.NDArray[np.float64], frame: Frame | None
    ) -> tuple[PartEstimate, ...]:
        """What can be said of all bodies after a frame; hidden ones go back to `predicted`.

        Args:
            predicted: (B, 4, 4) `camera_from_body` before the frame was seen.
            frame: of the first camera; None without one.
        """
        optimiser = self._optimiser
        evidence = [self._evidence(body, frame) for body in range(len(self._names))]
        believed = [self._judge.is_believed(body, each) for body, each in enumerate(evidence)]
        estimates = []
        for body in range(len(self._names)):
            members = [int(member) for member in optimiser.structures.members(body)]
            carrier = None
            if len(members) > 1:
                others = (evidence[m] for m in members if m != body and believed[m])
                carrier = sum(others, NO_EVIDENCE)
                if not any(believed[m] for m in members):
                    # Nobody of the module is seen well: it stays where it was expected.
                    optimiser.move(body, Pose(predicted[body]))
            estimates.append(self._estimate(body, evidence[body], carrier, predicted[body]))
        return tuple(estimates)

    def absent(self, estimates: Sequence[PartEstimate], frame: Frame | None) -> list[str]:
        """Linked parts that are not seen although their places are."""
        if frame is None:
            return []
        return [
            each.part
            for body, each in enumerate(estimates)
            if each.status is Status.INFERRED and each.camera_from_body is not None
            if self._seen_through.is_vacant(frame, body, each.camera_from_body)
        ]

    def _evidence(self, body: int, frame: Frame | None) -> Evidence:
        """What speaks for a body's pose; nothing does where the depth camera sees through it."""
        evidence = self._optimiser.evidence(body)
        if not self._refutes or frame is None or not self._optimiser.is_active(body):
            return evidence
        pose = self._optimiser.pose(body)
        if self._seen_through.contradicts(frame, body, pose, evidence):
            return replace(evidence, supporting_lines=0, supporting_points=0)
        return evidence

    def _estimate(
        self,
        body: int,
        evidence: Evidence,
        carrier: Evidence | None,
        predicted: npt.NDArray[np.float64],
    ) -> PartEstimate:
        """What can be said of a body after a frame."""
        name, optimiser = self._names[body], self._optimiser
        if not optimiser.is_active(body):
            return PartEstimate(name, Status.SEARCHING, 0.0, None)
        status = self._judge.judge(
            body, evidence, solved=optimiser.is_solved(body), carrier=carrier
        )
        if status is Status.LOST:
            optimiser.drop_if_diverged(body)
            return PartEstimate(name, status, 0.0, None, visibility=evidence.visibility)
        if status is Status.PREDICTED and carrier is None:
            # Next to no evidence would only make it drift.
            optimiser.move(body, Pose(predicted))
        confidence = evidence.confidence
        self.agreements[body] = confidence
        if status is Status.INFERRED and carrier is not None:
            confidence = self.agreements[body] = carrier.confidence
        elif status is Status.TRACKED:
            self.agreements[body] = evidence.agreement(carrier)
        return PartEstimate(
            name,
            status,
            confidence,
            optimiser.pose(body),
            visibility=evidence.visibility,
            linked_to=self._graph.parent_of(name) if self._graph is not None else None,
        )
