"""Unit quaternions x, y, z, w in plain Python: for a few parts faster than arrays are."""

from __future__ import annotations

import math
from collections.abc import Sequence

_SMALL_ANGLE_RAD = 1e-6


def multiply(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """The rotation `a @ b`: first b, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]


def inverse(q: Sequence[float]) -> list[float]:
    """The opposite rotation."""
    return [-q[0], -q[1], -q[2], q[3]]


def rotate(q: Sequence[float], v: Sequence[float]) -> list[float]:
    """A vector (3,), turned."""
    x, y, z, w = q
    tx = 2 * (y * v[2] - z * v[1])
    ty = 2 * (z * v[0] - x * v[2])
    tz = 2 * (x * v[1] - y * v[0])
    return [
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    ]


def exp(rotation_vector: Sequence[float]) -> list[float]:
    """The rotation by a rotation vector (3,), axis times angle, rad."""
    angle = math.hypot(*rotation_vector)
    if angle < _SMALL_ANGLE_RAD:
        half = [0.5 * each for each in rotation_vector]
        return normalised([*half, 1.0])
    scale = math.sin(angle / 2) / angle
    return [*(scale * each for each in rotation_vector), math.cos(angle / 2)]


def log(q: Sequence[float]) -> list[float]:
    """The rotation vector (3,), at most pi long, rad; inverts `exp`."""
    x, y, z, w = q if q[3] >= 0 else [-each for each in q]
    sine = math.hypot(x, y, z)
    scale = 2.0 if sine < _SMALL_ANGLE_RAD else 2 * math.atan2(sine, w) / sine
    return [scale * x, scale * y, scale * z]


def normalised(q: Sequence[float]) -> list[float]:
    """Of length 1, with w not negative."""
    length = math.hypot(*q)
    scale = (1.0 if q[3] >= 0 else -1.0) / length
    return [scale * each for each in q]
