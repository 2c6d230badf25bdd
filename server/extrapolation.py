"""Where a part will be: `?at_us=`.

A part goes on with the velocities of its last two frames. Nobody knows whether it does, so the
covariance grows: with the velocities' own error, and with the acceleration of a hand that takes up
or stops a part.
"""

from __future__ import annotations

from typing import Any

from snapfit.server import quaternion

LIMIT_S = 0.1
"""How far from the exposure poses are extrapolated, forwards and backwards."""

_VELOCITY_ERROR_M_PER_S = 0.02
_ACCELERATION_M_PER_S2 = 2.0
_ANGULAR_VELOCITY_ERROR_RAD_PER_S = 0.2
_ANGULAR_ACCELERATION_RAD_PER_S2 = 15.0


def extrapolated(part: dict[str, Any], ahead_s: float) -> dict[str, Any]:
    """A part of a snapshot, in the camera frame, some time later or earlier.

    A part without a pose has none then, and one without velocities stays where it is.

    Args:
        part: JSON of a `PartPose`.
        ahead_s: from the exposure; its limit is the caller's to keep.
    """
    if part["position"] is None or part["orientation"] is None or ahead_s == 0:
        return part
    result = dict(part)
    if part["linear_velocity"] is not None:
        result["position"] = [
            at + ahead_s * speed
            for at, speed in zip(part["position"], part["linear_velocity"], strict=True)
        ]
    if part["angular_velocity"] is not None:
        # The axis is given in the camera frame: the turn acts on the left.
        turn = quaternion.exp([ahead_s * each for each in part["angular_velocity"]])
        turned = quaternion.multiply(turn, part["orientation"])
        result["orientation"] = quaternion.normalised(turned)
    if part["covariance"] is not None:
        result["covariance"] = _grown(part["covariance"], ahead_s)
    return result


def _grown(covariance: list[float], ahead_s: float) -> list[float]:
    """Alike in all directions, so it does not matter how the body is turned."""
    turn = _variance(_ANGULAR_VELOCITY_ERROR_RAD_PER_S, _ANGULAR_ACCELERATION_RAD_PER_S2, ahead_s)
    way = _variance(_VELOCITY_ERROR_M_PER_S, _ACCELERATION_M_PER_S2, ahead_s)
    result = list(covariance)
    for axis in range(6):
        result[7 * axis] += turn if axis < 3 else way
    return result


def _variance(velocity_error: float, acceleration: float, ahead_s: float) -> float:
    return float((velocity_error * ahead_s) ** 2 + (acceleration * ahead_s**2 / 2) ** 2)
