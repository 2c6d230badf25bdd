"""How uncertain each body's pose is: the inverse Hessian of its structure, and systematic errors.

The energy of a structure is eliminated from the leaves to the root as for a Newton step (see
`structure.py`); back from the root to the leaves each body gets the marginal covariance of its own
variation. So a hidden body that is linked to one that is seen is as certain as its link makes it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from snapfit.tracking.kernels.structure import relative_adjoint
from snapfit.tracking.kernels.types import F64, Bodies, Structures


class CovarianceSettings(NamedTuple):
    """See `CovarianceParameters`; priors are Hessians, 1/rad^2 and 1/m^2."""

    information: float
    prior_rotation: float
    prior_translation: float
    distance: float
    place_m: float
    turn_rad: float


@njit(cache=True, nogil=True)
def covariances(
    structures: Structures, bodies: Bodies, centers: F64, settings: CovarianceSettings, out: F64
) -> None:
    """Covariance (6, 6) of each active body's right perturbation: rotation (rad), translation (m).

    Args:
        structures: how the bodies are linked.
        bodies: their Hessians (lower triangles) and poses.
        centers: (B, 3) of the bodies, body frame, m.
        settings: parameters.
        out: (B, 6, 6) written; not a number where the Hessian of a structure is not finite.
    """
    n_bodies = len(bodies.poses)
    hessians, adjoints = np.zeros((n_bodies, 6, 6)), np.zeros((n_bodies, 6, 6))
    gains, variances = np.zeros((n_bodies, 2, 6)), np.zeros((n_bodies, 2))
    for body in range(n_bodies):
        if bodies.active[body]:
            for i in range(6):
                for j in range(i + 1):
                    value = bodies.hessians[body, i, j] * settings.information
                    hessians[body, i, j] = value
                    hessians[body, j, i] = value
    for place in range(n_bodies - 1, -1, -1):
        body = structures.order[place]
        parent = structures.parents[body]
        if parent < 0:
            for i in range(6):
                prior = settings.prior_rotation if i < 3 else settings.prior_translation
                hessians[body, i, i] += prior
            continue
        relative_adjoint(bodies.poses[parent], bodies.poses[body], adjoints[body])
        _eliminate(body, structures, settings, hessians[body], gains[body], variances[body])
        hessians[parent] += adjoints[body].T @ hessians[body] @ adjoints[body]
    for place in range(n_bodies):
        body = structures.order[place]
        parent = structures.parents[body]
        if parent < 0:
            _invert(hessians[body], out[body])
            continue
        out[body] = adjoints[body] @ out[parent] @ adjoints[body].T
        for d in range(structures.n_dof[body]):
            _widen(structures.twists[body, d], gains[body, d], variances[body, d], out[body])
    for body in range(n_bodies):
        add_systematic(bodies.poses[body], centers[body], settings, out[body])


@njit(cache=True, nogil=True)
def add_systematic(pose: F64, center: F64, settings: CovarianceSettings, out: F64) -> None:
    """Add the systematic error of a body at `center`, (3,) body frame, to its covariance.

    A depth camera's error moves a body along the line of sight; a calibration's and a mesh's turn
    it and move it about its middle. `pose` is (4, 4) camera_from_body.
    """
    seen = np.empty(3)
    for i in range(3):
        seen[i] = pose[i, 3]
        for j in range(3):
            seen[i] += pose[i, j] * center[j]
    distance = np.sqrt(np.dot(seen, seen))
    sight = np.zeros(3)
    for j in range(3):
        for i in range(3):
            sight[j] += pose[i, j] * seen[i] / max(distance, 1e-9)
    turn = settings.turn_rad * settings.turn_rad
    place = settings.place_m * settings.place_m
    along = (settings.distance * distance) ** 2
    lever = np.zeros((3, 3))
    lever[0, 1], lever[0, 2], lever[1, 2] = -center[2], center[1], -center[0]
    lever[1, 0], lever[2, 0], lever[2, 1] = center[2], -center[1], center[0]
    for i in range(3):
        out[i, i] += turn
        out[i + 3, i + 3] += place
        for j in range(3):
            out[i + 3, j] += turn * lever[i, j]
            out[j, i + 3] += turn * lever[i, j]
            out[i + 3, j + 3] += along * sight[i] * sight[j]
            for k in range(3):
                out[i + 3, j + 3] += turn * lever[i, k] * lever[j, k]


@njit(cache=True, nogil=True)
def _eliminate(
    body: int,
    structures: Structures,
    settings: CovarianceSettings,
    hessian: F64,
    gains: F64,
    variances: F64,
) -> None:
    """Take the coordinates of a body's joint out of its Hessian, the last one first."""
    for d in range(structures.n_dof[body] - 1, -1, -1):
        twist = structures.twists[body, d]
        turns = twist[0] != 0.0 or twist[1] != 0.0 or twist[2] != 0.0
        pull = hessian @ twist
        stiffness = np.dot(twist, pull)
        stiffness += settings.prior_rotation if turns else settings.prior_translation
        gains[d] = -pull / stiffness
        variances[d] = 1.0 / stiffness
        for i in range(6):
            for j in range(6):
                hessian[i, j] -= pull[i] * pull[j] / stiffness


@njit(cache=True, nogil=True)
def _widen(twist: F64, gain: F64, variance: F64, out: F64) -> None:
    """The covariance of x + twist (gain . x + e), in place; the variance is that of e."""
    coupled = out @ gain
    own = np.dot(gain, coupled) + variance
    for i in range(6):
        for j in range(6):
            out[i, j] += twist[i] * coupled[j] + coupled[i] * twist[j] + own * twist[i] * twist[j]


@njit(cache=True, nogil=True)
def _invert(hessian: F64, out: F64) -> None:
    """The inverse of a positive definite matrix (6, 6)."""
    if np.isfinite(hessian).all():
        out[:] = np.linalg.inv(hessian)
    else:
        out[:] = np.nan
