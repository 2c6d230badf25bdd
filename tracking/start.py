"""Hypotheses around a rough first pose.

A pose that is some millimetres and degrees off may be drawn to a wrong place: one starting point
is not enough where a part is half hidden. The patterns cover the directions that a single view
shows least: turns about the body's axes, and the distance from the camera.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from snapfit.models.pose import Pose
from snapfit.tracking.parameters import StartParameters

Variation = Callable[[Pose], Pose]


def start_variations(parameters: StartParameters) -> Iterator[Variation]:
    """Ways to vary a first pose `camera_from_body`; the first leaves it as it is."""
    yield lambda pose: pose
    for axis in range(3):
        for sign in (1, -1):
            yield _turn(axis, sign * math.radians(parameters.rotation_deg))
    for sign in (1, -1):
        yield _push(sign * parameters.distance_m)


def _turn(axis: int, angle_rad: float) -> Variation:
    variation = np.zeros(6)
    variation[axis] = angle_rad
    return lambda pose: pose.perturbed(variation)


def _push(distance_m: float) -> Variation:
    def push(pose: Pose) -> Pose:
        direction = pose.translation / np.linalg.norm(pose.translation)
        return Pose.from_rotation_translation(
            pose.rotation, pose.translation + distance_m * direction
        )

    return push
