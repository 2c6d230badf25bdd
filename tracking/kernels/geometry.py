"""Small geometry that every kernel uses; inlined by the compiler."""

from __future__ import annotations

import numpy as np
from numba import njit

from snapfit.tracking.kernels.types import F32, F64, FAST, Intrinsics


@njit(cache=True, nogil=True, forceinline=True)
def intrinsics(camera: F32) -> Intrinsics:
    """Names for (6,) fx, fy, cx, cy, width, height."""
    return Intrinsics(camera[0], camera[1], camera[2], camera[3], int(camera[4]), int(camera[5]))


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def rotate(pose: F32, x: np.float32, y: np.float32, z: np.float32) -> tuple[F32, F32, F32]:
    """A direction through the rotation of a pose (4, 4)."""
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z,
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z,
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z,
    )


@njit(cache=True, nogil=True, fastmath=FAST, forceinline=True)
def transform(pose: F32, x: np.float32, y: np.float32, z: np.float32) -> tuple[F32, F32, F32]:
    """A point, metres, through a pose (4, 4)."""
    rx, ry, rz = rotate(pose, x, y, z)
    return rx + pose[0, 3], ry + pose[1, 3], rz + pose[2, 3]


@njit(cache=True, nogil=True, fastmath=FAST)
def multiply_poses(a: F64, b: F64, out: F32) -> None:
    """Out = a @ b for poses (4, 4)."""
    for i in range(3):
        for j in range(4):
            value = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
            out[i, j] = value + a[i, 3] if j == 3 else value
    for j in range(4):
        out[3, j] = 1.0 if j == 3 else 0.0
