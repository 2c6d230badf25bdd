"""`GET /resource`: the JSON of the GBOT authors' own server, for clients that were made for it.

A list of parts with metres and degrees, in Unity's axes, with half a turn more about z, which
Unity's importer of OBJ files makes necessary. Unity applies Euler angles in the order z, x, y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from snapfit.server.conventions import AXES, Convention
from snapfit.server.rigid import Rigid

_UNITY = AXES[Convention.UNITY]
_TURN_DEG = 180.0


def gbot_parts(snapshot: dict[str, Any]) -> list[dict[str, Any]]:
    """The parts that have a pose, as GBOT's server tells them.

    Args:
        snapshot: JSON of a `PoseSnapshot` in the camera frame and OpenCV's axes.
    """
    return [_part(part) for part in snapshot["parts"] if part["position"] is not None]


def _part(part: dict[str, Any]) -> dict[str, Any]:
    pose = Rigid(part["position"], part["orientation"]).along(_UNITY)
    x_deg, y_deg, z_deg = unity_euler_deg(pose.orientation)
    x, y, z = pose.position
    return {
        "classId": part["part"],
        "x": x,
        "y": y,
        "z": z,
        "qx": x_deg,
        "qy": y_deg,
        "qz": z_deg + _TURN_DEG,
    }


def unity_euler_deg(orientation: Sequence[float]) -> tuple[float, float, float]:
    """Angles about x, y, z in degrees, such that the rotation is Ry @ Rx @ Rz.

    Args:
        orientation: unit quaternion x, y, z, w.
    """
    x, y, z, w = orientation
    sine = 2 * (w * x - y * z)
    if abs(sine) > 1 - 1e-12:  # looking straight up or down: z is taken to be zero
        about_y = 2 * math.atan2(y, w)
        return math.copysign(90.0, sine), math.degrees(math.remainder(about_y, math.tau)), 0.0
    about_y = math.atan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y))
    about_z = math.atan2(2 * (x * y + w * z), 1 - 2 * (x * x + z * z))
    return math.degrees(math.asin(sine)), math.degrees(about_y), math.degrees(about_z)
