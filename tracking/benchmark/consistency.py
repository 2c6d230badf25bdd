"""Normalised estimation error squared: whether a covariance says how wrong its pose is.

NEES is e^T C^-1 e with e the error in the tangent space of the pose and C the stated covariance
(Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, section 5.4).
It is divided by its degrees of freedom here, so that 1 is expected of an honest covariance; more
means that the method believes itself too much, less that it believes itself too little.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry

Array = npt.NDArray[np.float64]

UNKNOWN = np.full(3, np.nan)
DEGREES_OF_FREEDOM = 6


def normalised_error(
    estimate: Pose, nearest: Pose, truth: Pose, symmetry: Symmetry, covariance: Array
) -> Array:
    """(3,) NEES per degree of freedom: of the whole pose, its rotation, its translation.

    The error is the right perturbation of the body frame that leads from the estimate to the true
    pose. A turn about an axis of symmetry is no error and has no variance: it is left out, and
    the translation is that of a point on the axis.

    Args:
        estimate: `camera_from_body`.
        nearest: the pose that looks like the estimate and is nearest to the truth.
        truth: `camera_from_body`.
        symmetry: of the body.
        covariance: (6, 6) of the right perturbation, rotation (rad) then translation (m).

    Returns:
        Not a number where the covariance cannot be inverted: it claims to know something exactly.
    """
    same_looking_truth = truth @ nearest.inverse() @ estimate
    error = (estimate.inverse() @ same_looking_truth).log()
    rotation = np.eye(3)
    if symmetry.axis is not None:
        moved = Pose.from_translation(*-symmetry.axis.point_m).adjoint()
        error, covariance = moved @ error, moved @ covariance @ moved.T
        rotation = np.linalg.svd(symmetry.axis.direction[None])[2][1:]
    n = len(rotation)
    kept = np.zeros((n + 3, 6))
    kept[:n, :3], kept[n:, 3:] = rotation, np.eye(3)
    error, covariance = kept @ error, kept @ covariance @ kept.T
    blocks = (slice(None), slice(n), slice(n, None))
    return np.array([_normalised(error[each], covariance[each, each]) for each in blocks])


def _normalised(error: Array, covariance: Array) -> float:
    try:
        factor = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        return float("nan")
    whitened = np.linalg.solve(factor, error)
    return float(whitened @ whitened) / len(error)
