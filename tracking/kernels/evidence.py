"""What of a frame speaks for a body's pose: agreeing lines and points, and their likelihood."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from snapfit.tracking.kernels.geometry import intrinsics, rotate, transform
from snapfit.tracking.kernels.types import (
    F32,
    F64,
    FAST,
    I64,
    Bodies,
    Cameras,
    Intrinsics,
    Lines,
    Models,
    Points,
)

_BINS = 12
_NARROW = np.float32(6.0)
"""Variance, segments squared, under which a posterior says where its contour is (even: 11.9)."""
_WORST_LINE = -2.5
_WORST_POINT = -1.0


@njit(cache=True, nogil=True, fastmath=FAST)
def weigh_lines(
    body: int, n_lines: int, camera: Intrinsics, pose: F32, lines: Lines, tolerance_px: np.float32
) -> tuple[int, np.float32]:
    """How many valid lines see their contour where a pose puts it, and their log likelihood.

    A line agrees when the mean of its posterior lies within the tolerance and the posterior is
    narrow. Its log likelihood is that of the contour's place against an even posterior, so that a
    line which says nothing adds nothing; one bad line can take away no more than 2.5.
    """
    agreeing = 0
    likelihood = np.float32(0.0)
    for i in range(n_lines):
        if lines.valid[body, i] == 0:
            continue
        point, place, moment = lines.point[body, i], lines.place[body, i], lines.moments[body, i]
        x, y, z = transform(pose, point[0], point[1], point[2])
        u = camera.fx * x / z + camera.cx
        v = camera.fy * y / z + camera.cy
        moved = place[2] * (u - place[0]) + place[3] * (v - place[1])
        delta = (moved - place[4]) * place[5]
        if abs(moment[0] - delta) < tolerance_px * place[5] and moment[1] < _NARROW:
            agreeing += 1
        upper = math.floor(delta + np.float32(0.5 * _BINS))
        if 0 <= upper < _BINS:
            share = max(lines.posterior[body, i, upper], np.float32(1e-6))
            likelihood += max(math.log(_BINS * share), _WORST_LINE)
        else:
            likelihood += _WORST_LINE
    return agreeing, likelihood


@njit(cache=True, nogil=True, fastmath=FAST)
def weigh_points(
    body: int, n_points: int, pose: F32, points: Points, tolerance_m: np.float32
) -> tuple[int, np.float32, np.float32]:
    """How many valid points lie within the tolerance of their measured plane, and a likelihood.

    The likelihood of a point is 1 - (error / tolerance)^2, and no less than -1. Last, the root
    mean square of the errors, m at 1 m distance; 0 without a point.
    """
    agreeing, n_valid = 0, 0
    likelihood = np.float32(0.0)
    squares = np.float32(0.0)
    for i in range(n_points):
        if points.valid[body, i] == 0:
            continue
        point, normal = points.point[body, i], points.normal[body, i]
        measured = points.measured[body, i]
        nx, ny, nz = rotate(pose, normal[0], normal[1], normal[2])
        x, y, z = transform(pose, point[0], point[1], point[2])
        error = nx * (x - measured[0]) + ny * (y - measured[1]) + nz * (z - measured[2])
        share = error / tolerance_m
        if share * share < 1.0:
            agreeing += 1
        likelihood += max(np.float32(1.0) - share * share, _WORST_POINT)
        squares += error * error / (z * z)
        n_valid += 1
    return agreeing, likelihood, np.float32(math.sqrt(squares / max(n_valid, 1)))


@njit(cache=True, nogil=True)
def weigh_bodies(
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    lines: Lines,
    points: Points,
    tolerance_px: float,
    tolerance_m: float,
    support: I64,
    likelihoods: F64,
    depth_errors: F64,
) -> None:
    """Agreeing lines and points (B, 2) and log likelihood (B,) of each active body's pose.

    `depth_errors` (B,) are root mean squares of the points' errors, m at 1 m distance.

    Uses the correspondences of the last refinement.
    """
    for body in range(bodies.poses.shape[0]):
        support[body] = 0
        likelihoods[body] = -np.inf
        depth_errors[body] = 0.0
        if not bodies.active[body]:
            continue
        view = bodies.views[body]
        bodies.color_poses[body] = bodies.poses[body]
        pose = bodies.color_poses[body]
        n_lines, of_lines = weigh_lines(
            body,
            models.line_counts[body, view],
            intrinsics(cameras.color),
            pose,
            lines,
            np.float32(tolerance_px),
        )
        n_points, of_points, depth_errors[body] = weigh_points(
            body, models.point_counts[body, view], pose, points, np.float32(tolerance_m)
        )
        support[body, 0], support[body, 1] = n_lines, n_points
        likelihoods[body] = of_lines + of_points
