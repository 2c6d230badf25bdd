"""Refines a part among others whose poses are known, which hide what they hide of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser
from snapfit.tracking.parameters import TrackerParameters

_MARGINS_PX = (4.0, 2.0, 2.0)


class AmongOthers:
    """The tracker's own optimiser, for one part at a time.

    Args:
        bodies: all that may be there.
        camera: where the frames come from.
    """

    def __init__(self, bodies: Sequence[Body], camera: RgbdCamera) -> None:
        self._index = {body.name: i for i, body in enumerate(bodies)}
        self._optimiser = Optimiser(bodies, camera, TrackerParameters())

    def settle(
        self, frame: Frame, name: str, pose: Pose, known: Mapping[str, Pose]
    ) -> Attempt | None:
        """Refine a part from a pose, learning its colours in turns; None without a solution.

        Args:
            frame: in which it is seen.
            name: of the part.
            pose: `camera_from_body` to start from.
            known: where others are; they stay there.
        """
        optimiser, body = self._optimiser, self._index[name]
        for other in self._index.values():
            optimiser.deactivate(other)
        for other_name, other_pose in known.items():
            optimiser.place(self._index[other_name], other_pose)
        optimiser.place(body, pose)
        optimiser.see(frame)  # draws who hides whom
        for other in self._index.values():
            if other != body:
                optimiser.deactivate(other)
        which = np.zeros(len(self._index), dtype=np.int64)
        which[body] = 1
        optimiser.correspond()
        for margin_px in _MARGINS_PX:
            optimiser.learn(which, afresh_beyond_px=margin_px)
            optimiser.refine()
            if not optimiser.is_solved(body):
                return None
        optimiser.weigh()
        likelihood, evidence = float(optimiser.likelihoods[body]), optimiser.evidence(body)
        return Attempt(optimiser.pose(body), likelihood, evidence, solved=True)
