"""What is published of a pose: the probability that it is right, and how far off it can be.

The tracker itself goes by the share of evidence that agrees (`Evidence.confidence`): it compares
poses. Whoever uses a pose wants to know what that share is worth. So a tracked pose's share is
mapped to a probability; a part that is not seen is believed less and less, and its pose grows
uncertain, from where it was seen last.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from snapfit.tracking.parameters import ConfidenceParameters, CovarianceParameters
from snapfit.tracking.result import PartEstimate, Status

Array = npt.NDArray[np.float64]


class Calibration:
    """Calibrates the estimates of one tracker, frame after frame.

    Args:
        n_bodies: of the tracker.
        confidence, covariance: parameters.
        reachable: share of agreeing evidence when all is well, 0 to 1; less than 1 without depth.
    """

    def __init__(
        self,
        n_bodies: int,
        confidence: ConfidenceParameters,
        covariance: CovarianceParameters,
        *,
        reachable: float = 1.0,
    ) -> None:
        self._parameters, self._reachable = confidence, reachable
        turn, way = covariance.unseen_turn_rad, covariance.unseen_way_m
        self._growth = np.diag([turn**2] * 3 + [way**2] * 3)
        self._unseen = [0] * n_bodies
        self._known = [0.0] * n_bodies
        self._covariances: list[Array | None] = [None] * n_bodies

    def published(
        self, estimates: Sequence[PartEstimate], agreements: Sequence[float], covariances: Array
    ) -> tuple[PartEstimate, ...]:
        """The estimates of a frame, calibrated.

        Args:
            estimates: of all bodies.
            agreements: the share of evidence that agrees with each, 0 to 1.
            covariances: (B, 6, 6) of the poses, as far as this frame says.
        """
        return tuple(
            self._published(body, each, agreements[body], covariances[body])
            for body, each in enumerate(estimates)
        )

    def _published(
        self, body: int, estimate: PartEstimate, agreement: float, covariance: Array
    ) -> PartEstimate:
        if estimate.camera_from_body is None:
            self._known[body], self._covariances[body] = 0.0, None
            return replace(estimate, confidence=0.0, covariance=None)
        confidence = self.probability(agreement)
        if estimate.status is not Status.PREDICTED:
            if confidence >= self._parameters.sure:
                self._unseen[body], self._known[body] = 0, confidence
                self._covariances[body] = covariance
            else:
                self._unseen[body] += 1
            return replace(estimate, confidence=confidence, covariance=covariance)
        self._unseen[body] += 1
        remembered = self._known[body] * math.exp(
            -self._unseen[body] / self._parameters.memory_frames
        )
        if (known := self._covariances[body]) is not None:
            covariance = known + self._unseen[body] ** 2 * self._growth
        # Right by what little is seen, or else still where it was.
        confidence += (1 - confidence) * remembered
        return replace(estimate, confidence=confidence, covariance=covariance)

    def probability(self, agreement: float) -> float:
        """That a pose is right with which this share of the evidence agrees, 0 to 1."""
        p = self._parameters
        odds = p.steepness * (agreement / self._reachable - p.middle)
        return p.best / (1 + math.exp(-odds))
