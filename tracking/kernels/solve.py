"""The Newton step of a body and the update of its pose."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from snapfit.tracking.kernels.types import F64


@njit(cache=True, nogil=True)
def newton_step(
    gradient: F64, hessian: F64, rotation: float, translation: float, step: F64
) -> bool:
    """Solve (H + Tikhonov) step = -g by Cholesky's decomposition (M3T).

    Args:
        gradient: (6,) of the energy.
        hessian: (6, 6) lower triangle; overwritten.
        rotation, translation: Tikhonov regularisation, 1/rad^2 and 1/m^2.
        step: (6,) written.

    Returns:
        False where the system is not positive definite or anything is not finite; the step is
        then no step, and the body is to be called lost.
    """
    for i in range(6):
        hessian[i, i] += rotation if i < 3 else translation
    for i in range(6):
        for j in range(i + 1):
            value = hessian[i, j]
            for k in range(j):
                value -= hessian[i, k] * hessian[j, k]
            if i == j:
                if not (value > 0.0 and np.isfinite(value)):
                    return False
                hessian[i, i] = math.sqrt(value)
            else:
                hessian[i, j] = value / hessian[j, j]
    for i in range(6):
        value = -gradient[i]
        for k in range(i):
            value -= hessian[i, k] * step[k]
        step[i] = value / hessian[i, i]
    for i in range(5, -1, -1):
        value = step[i]
        for k in range(i + 1, 6):
            value -= hessian[k, i] * step[k]
        step[i] = value / hessian[i, i]
        if not np.isfinite(step[i]):
            return False
    return True


@njit(cache=True, nogil=True)
def apply_variation(pose: F64, step: F64) -> None:
    """Pose = pose exp(step), in place: rotation by Rodrigues' formula, then the translation.

    Args:
        pose: (4, 4) camera_from_body.
        step: (6,) rotation (rad), translation (m), body frame.
    """
    wx, wy, wz = step[0], step[1], step[2]
    angle = math.sqrt(wx * wx + wy * wy + wz * wz)
    a = 1.0 - angle * angle / 6.0 if angle < 1e-4 else math.sin(angle) / angle
    b = 0.5 if angle < 1e-4 else (1.0 - math.cos(angle)) / (angle * angle)
    rotation = np.empty((3, 3))
    rotation[0, 0] = 1.0 - b * (wy * wy + wz * wz)
    rotation[0, 1] = -a * wz + b * wx * wy
    rotation[0, 2] = a * wy + b * wx * wz
    rotation[1, 0] = a * wz + b * wx * wy
    rotation[1, 1] = 1.0 - b * (wx * wx + wz * wz)
    rotation[1, 2] = -a * wx + b * wy * wz
    rotation[2, 0] = -a * wy + b * wx * wz
    rotation[2, 1] = a * wx + b * wy * wz
    rotation[2, 2] = 1.0 - b * (wx * wx + wy * wy)
    for i in range(3):
        r0, r1, r2 = pose[i, 0], pose[i, 1], pose[i, 2]
        pose[i, 3] += r0 * step[3] + r1 * step[4] + r2 * step[5]
        for j in range(3):
            pose[i, j] = r0 * rotation[0, j] + r1 * rotation[1, j] + r2 * rotation[2, j]


@njit(cache=True, nogil=True)
def exponential(twist: F64, out: F64) -> None:
    """Exponential of SE(3), rotation by Rodrigues' formula, translation by its left Jacobian.

    Args:
        twist: (6,) rotation (rad), translation (m).
        out: (4, 4) written.
    """
    wx, wy, wz = twist[0], twist[1], twist[2]
    angle2 = wx * wx + wy * wy + wz * wz
    if angle2 < 1e-8:
        a, b, c = 1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0, 1.0 / 6.0 - angle2 / 120.0
    else:
        angle = math.sqrt(angle2)
        a, b = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle2
        c = (1.0 - a) / angle2
    hat = np.array([[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]])
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0
    for i in range(3):
        out[i, 3] = 0.0
        for j in range(3):
            square = hat[i, 0] * hat[0, j] + hat[i, 1] * hat[1, j] + hat[i, 2] * hat[2, j]
            unit = 1.0 if i == j else 0.0
            out[i, j] = unit + a * hat[i, j] + b * square
            out[i, 3] += (unit + b * hat[i, j] + c * square) * twist[3 + j]
