"""Gradient (6,) and Hessian (6, 6) of a body, over the variation of its pose.

The variation acts on the right, in the body frame: rotation (rad), then translation (m). Both are
of the negative logarithm of the probability: the Newton step is -H^-1 g (M3T).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from snapfit.tracking.kernels.types import F32, F64, FAST, Intrinsics, Lines, Points, RegionSettings

_BINS = 12


@njit(cache=True, nogil=True, fastmath=FAST)
def add_region(
    body: int,
    n_lines: int,
    pose: F32,
    camera: Intrinsics,
    settings: RegionSettings,
    iteration: int,
    use_moments: bool,
    lines: Lines,
    gradient: F64,
    hessian: F64,
    jacobian: F32,
) -> None:
    """Add the correspondence lines' part (SRT3D).

    Args:
        body: index of the body in `lines`.
        n_lines: lines to look at.
        pose: (4, 4) camera_from_body.
        camera: the colour camera.
        settings: parameters.
        iteration: correspondence iteration, selects the deviation.
        use_moments: global optimisation by mean and variance, or local by the slope.
        lines: correspondences.
        gradient, hessian: added to.
        jacobian: (6,) room.
    """
    sigma = settings.sigmas[iteration]
    for i in range(n_lines):
        if lines.valid[body, i] == 0:
            continue
        point, place, moment = lines.point[body, i], lines.place[body, i], lines.moments[body, i]
        px, py, pz = point[0], point[1], point[2]
        x = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz + pose[0, 3]
        y = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz + pose[1, 3]
        z = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz + pose[2, 3]
        if z <= 0.0:
            continue
        fx_z, fy_z = camera.fx / z, camera.fy / z
        nu, nv, per_px = place[2], place[3], place[5]
        moved = nu * (x * fx_z + camera.cx - place[0]) + nv * (y * fy_z + camera.cy - place[1])
        # Where the model's contour now lies on the line, segments from the line's centre.
        delta = (moved - place[4]) * per_px
        variance = moment[1]
        if use_moments:
            slope = (moment[0] - delta) / variance
        else:
            upper = math.floor(delta + np.float32(0.5 * (_BINS + 1)))
            if upper <= 0 or upper >= _BINS:
                continue
            low = max(lines.posterior[body, i, upper - 1], np.float32(1e-12))
            high = max(lines.posterior[body, i, upper], np.float32(1e-12))
            slope = math.log(high / low) * settings.learning_rate / variance
        jx = nu * fx_z * per_px
        jy = nv * fy_z * per_px
        jz = -(jx * x + jy * y) / z
        body_jacobian(pose, px, py, pz, jx, jy, jz, jacobian)
        weight = settings.min_variance / (per_px * per_px * sigma * sigma)
        # A line whose posterior lies far off (a shadow, a reflection) counts less: Cauchy.
        outlying = (moment[0] - delta) / (per_px * settings.outlying * sigma)
        weight /= np.float32(1.0) + outlying * outlying
        add_outer(jacobian, -weight * slope, weight / variance, gradient, hessian)


@njit(cache=True, nogil=True, fastmath=FAST)
def add_depth(
    body: int,
    n_points: int,
    pose: F32,
    points: Points,
    gradient: F64,
    hessian: F64,
    jacobian: F32,
) -> None:
    """Add the surface points' part: point-to-plane errors (ICG).

    Args:
        body: index of the body in `points`.
        n_points: points to look at.
        pose: (4, 4) camera_from_body.
        points: correspondences.
        gradient, hessian: added to.
        jacobian: (6,) room.
    """
    for i in range(n_points):
        if points.valid[body, i] == 0:
            continue
        point, normal = points.point[body, i], points.normal[body, i]
        measured = points.measured[body, i]
        px, py, pz = point[0], point[1], point[2]
        nx = pose[0, 0] * normal[0] + pose[0, 1] * normal[1] + pose[0, 2] * normal[2]
        ny = pose[1, 0] * normal[0] + pose[1, 1] * normal[1] + pose[1, 2] * normal[2]
        nz = pose[2, 0] * normal[0] + pose[2, 1] * normal[1] + pose[2, 2] * normal[2]
        x = pose[0, 0] * px + pose[0, 1] * py + pose[0, 2] * pz + pose[0, 3]
        y = pose[1, 0] * px + pose[1, 1] * py + pose[1, 2] * pz + pose[1, 3]
        z = pose[2, 0] * px + pose[2, 1] * py + pose[2, 2] * pz + pose[2, 3]
        error = nx * (x - measured[0]) + ny * (y - measured[1]) + nz * (z - measured[2])
        # Plane and point both move with the body, the measured point stays: so the lever is to
        # the measured point.
        rx, ry, rz = measured[0] - pose[0, 3], measured[1] - pose[1, 3], measured[2] - pose[2, 3]
        bx = pose[0, 0] * rx + pose[1, 0] * ry + pose[2, 0] * rz
        by = pose[0, 1] * rx + pose[1, 1] * ry + pose[2, 1] * rz
        bz = pose[0, 2] * rx + pose[1, 2] * ry + pose[2, 2] * rz
        body_jacobian(pose, bx, by, bz, nx, ny, nz, jacobian)
        weight = points.weight[body, i]
        add_outer(jacobian, weight * error, weight, gradient, hessian)


@njit(cache=True, nogil=True, fastmath=FAST)
def body_jacobian(
    pose: F32,
    px: np.float32,
    py: np.float32,
    pz: np.float32,
    jx: np.float32,
    jy: np.float32,
    jz: np.float32,
    out: F32,
) -> None:
    """Chain a row (1, 3) over a point in the camera frame to one (6,) over the body's variation."""
    tx = jx * pose[0, 0] + jy * pose[1, 0] + jz * pose[2, 0]
    ty = jx * pose[0, 1] + jy * pose[1, 1] + jz * pose[2, 1]
    tz = jx * pose[0, 2] + jy * pose[1, 2] + jz * pose[2, 2]
    out[0] = py * tz - pz * ty
    out[1] = pz * tx - px * tz
    out[2] = px * ty - py * tx
    out[3], out[4], out[5] = tx, ty, tz


@njit(cache=True, nogil=True, fastmath=FAST)
def add_outer(
    jacobian: F32, slope: np.float32, weight: np.float32, gradient: F64, hessian: F64
) -> None:
    """Gradient += slope J, hessian += weight J^T J (lower triangle)."""
    for r in range(6):
        gradient[r] += slope * jacobian[r]
        for c in range(r + 1):
            hessian[r, c] += weight * jacobian[r] * jacobian[c]
