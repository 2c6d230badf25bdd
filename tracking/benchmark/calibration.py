"""Whether a method knows how good it is: confidences and covariances against the true errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2

from snapfit.tracking.benchmark.consistency import DEGREES_OF_FREEDOM
from snapfit.tracking.benchmark.run import STATUSES, Run
from snapfit.tracking.benchmark.scores import STRICT_SHARE
from snapfit.tracking.result import Status

Array = npt.NDArray[np.float64]

N_BINS = 10
_COVERAGE = 0.95


@dataclass(frozen=True)
class Reliability:
    """Confidence against the share of right poses; right is an ADD(-S) below 10 % of the diameter.

    Attributes:
        counts: poses by bin; ten bins of equal width from 0 to 1.
        confidences: their mean confidence; not a number for an empty bin.
        right: share of them that are right, 0 to 1.
        calibration_error: mean of |confidence - share that is right| over the bins, weighted by
            poses (ECE, Naeini et al. 2015), 0 to 1.
    """

    counts: tuple[int, ...]
    confidences: tuple[float, ...]
    right: tuple[float, ...]
    calibration_error: float


@dataclass(frozen=True)
class Consistency:
    """NEES per degree of freedom of parts that are `tracked`; 1 is expected.

    Attributes:
        mean: over all poses.
        rotation, translation: of these alone.
        mean_of_right: of poses whose ADD(-S) is below 10 % of the diameter: what is lost without
            notice weighs millions otherwise.
        median: over the median of the chi-square distribution, so that 1 is expected here too.
        covered: share of poses inside the ellipsoid that should hold 95 %.
    """

    mean: float
    rotation: float
    translation: float
    mean_of_right: float
    median: float
    covered: float


@dataclass(frozen=True)
class Calibration:
    """What a method says of itself, over some runs.

    Attributes:
        reliability: of its confidences.
        consistency: of its covariances.
        statuses: share of parts and frames by status, 0 to 1.
    """

    reliability: Reliability
    consistency: Consistency
    statuses: dict[str, float]


def calibration(runs: Sequence[Run]) -> Calibration:
    """The calibration over all parts and frames of some runs of one method."""
    statuses = np.concatenate([run.statuses.ravel() for run in runs])
    right = np.concatenate([run.is_within(STRICT_SHARE).ravel() for run in runs])
    has_pose = np.concatenate([run.has_estimate.ravel() for run in runs])
    confidences = np.concatenate([run.confidences.ravel() for run in runs])
    nees = np.concatenate([run.nees.reshape(-1, 3) for run in runs])
    believed = (statuses == STATUSES.index(Status.TRACKED)) & np.isfinite(nees).all(axis=1)
    return Calibration(
        reliability(confidences[has_pose], right[has_pose]),
        _consistency(nees[believed], right[believed]),
        {each.value: float((statuses == i).mean()) for i, each in enumerate(STATUSES)},
    )


def reliability(confidences: Array, right: npt.NDArray[np.bool_]) -> Reliability:
    """Bins poses by confidence.

    Args:
        confidences: (N,) 0 to 1.
        right: (N,) whether each pose is right.
    """
    bins = np.minimum((confidences * N_BINS).astype(np.int64), N_BINS - 1)
    counts = np.bincount(bins, minlength=N_BINS)
    filled = np.maximum(counts, 1)
    empty = np.where(counts > 0, 0.0, np.nan)
    stated = np.bincount(bins, confidences, N_BINS) / filled + empty
    true = np.bincount(bins, right.astype(np.float64), N_BINS) / filled + empty
    gaps = np.nansum(counts * abs(stated - true))
    return Reliability(
        tuple(counts.tolist()),
        tuple(stated.tolist()),
        tuple(true.tolist()),
        float(gaps / len(bins)) if len(bins) else math.nan,
    )


def _consistency(nees: Array, right: npt.NDArray[np.bool_]) -> Consistency:
    if not len(nees):
        return Consistency(*[math.nan] * 6)
    whole, rotation, translation = nees.T
    # The ellipsoid of an axially symmetric part has five dimensions; the difference is small.
    expected = chi2(DEGREES_OF_FREEDOM)
    return Consistency(
        mean=float(whole.mean()),
        rotation=float(rotation.mean()),
        translation=float(translation.mean()),
        mean_of_right=float(whole[right].mean()) if right.any() else math.nan,
        median=float(np.median(whole) / (expected.median() / DEGREES_OF_FREEDOM)),
        covered=float((whole < expected.ppf(_COVERAGE) / DEGREES_OF_FREEDOM).mean()),
    )
