"""Starting from rough first poses: hypotheses around them, the likeliest of which wins.

A pose that is some millimetres and degrees off may be drawn to a wrong place: one starting point
is not enough where a part is half hidden. The patterns cover the directions that a single view
shows least: turns about the body's axes, and the distance from the camera.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import StartParameters

Variation = Callable[[Pose], Pose]


class Starter:
    """Refines first poses, and learns the colours of bodies at them.

    Args:
        optimiser: whose bodies they are.
        parameters: which hypotheses are tried, and how colours are learned.
    """

    def __init__(self, optimiser: Optimiser, parameters: StartParameters) -> None:
        self._optimiser, self._parameters = optimiser, parameters

    def start(
        self,
        frames: Sequence[Frame | None],
        camera_from_body: Mapping[int, Pose],
        *,
        are_rough: bool,
    ) -> None:
        """Put bodies at the likeliest of the poses around those that are given, and refine them.

        Args:
            frames: of each camera.
            camera_from_body: where bodies are, roughly.
            are_rough: False to try nothing around the poses.
        """
        which = np.zeros(len(self._optimiser.poses), dtype=np.int64)
        which[[*camera_from_body]] = 1
        best = dict(camera_from_body)
        likelihood = dict.fromkeys(camera_from_body, -np.inf)
        for variation in start_variations(self._parameters) if are_rough else ():
            varied = {body: variation(pose) for body, pose in camera_from_body.items()}
            self._settle(frames, which, varied)
            for body in camera_from_body:
                if self._optimiser.likelihoods[body] > likelihood[body]:
                    likelihood[body] = self._optimiser.likelihoods[body]
                    best[body] = self._optimiser.pose(body)
        self._settle(frames, which, best)

    def _settle(
        self,
        frames: Sequence[Frame | None],
        which: npt.NDArray[np.int64],
        camera_from_body: Mapping[int, Pose],
    ) -> None:
        """Put bodies at poses, then refine them and learn their colours in turns."""
        for body, pose in camera_from_body.items():
            self._optimiser.place(body, pose)
        self._optimiser.see(*frames)
        self._optimiser.correspond()
        for margin_px in self._parameters.margins_px:
            self._optimiser.learn(which, afresh_beyond_px=margin_px)
            self._optimiser.refine()
        self._optimiser.weigh()
        self._optimiser.learn(which, afresh_beyond_px=0.0)


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
