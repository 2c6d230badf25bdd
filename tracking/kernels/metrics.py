"""The largest distance over all points, least over all symmetries: MSSD and MSPD.

A symmetry is given up at the first point that lies further away than the best so far, so that
hundreds of them cost little more than one. Points that stick out should come first.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[np.float64]


@njit(cache=True, nogil=True)
def least_largest_distance_m(moved: Array, points: Array, motions: Array) -> float:
    """MSSD in the true body frame.

    Args:
        moved: (N, 3) points at the estimate, m.
        points: (N, 3) the same points of the body, m.
        motions: (S, 4, 4) the symmetries, m.
    """
    least = np.inf
    for k in range(len(motions)):
        motion = motions[k]
        largest = 0.0
        for i in range(len(points)):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            dx = motion[0, 0] * x + motion[0, 1] * y + motion[0, 2] * z + motion[0, 3] - moved[i, 0]
            dy = motion[1, 0] * x + motion[1, 1] * y + motion[1, 2] * z + motion[1, 3] - moved[i, 1]
            dz = motion[2, 0] * x + motion[2, 1] * y + motion[2, 2] * z + motion[2, 3] - moved[i, 2]
            largest = max(largest, dx * dx + dy * dy + dz * dz)
            if largest >= least:
                break
        least = min(least, largest)
    return math.sqrt(least)


@njit(cache=True, nogil=True, error_model="numpy")
def least_largest_distance_px(
    pixels: Array, points: Array, camera_from_body: Array, intrinsics: Array
) -> float:
    """MSPD.

    Args:
        pixels: (N, 2) points projected at the estimate, px.
        points: (N, 3) the same points of the body, m.
        camera_from_body: (S, 4, 4) the true pose with every symmetry, m.
        intrinsics: (4,) fx, fy, cx, cy, px.
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    least = np.inf
    for k in range(len(camera_from_body)):
        pose = camera_from_body[k]
        largest = 0.0
        for i in range(len(points)):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            px = pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3]
            py = pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3]
            pz = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3]
            du = fx * px / pz + cx - pixels[i, 0]
            dv = fy * py / pz + cy - pixels[i, 1]
            largest = max(largest, du * du + dv * dv)
            if largest >= least:
                break
        least = min(least, largest)
    return math.sqrt(least)
