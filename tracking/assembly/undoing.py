"""Evidence that a link of the current state no longer holds: its part is somewhere else."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from snapfit.models.pose import Pose
from snapfit.tracking.assembly.estimate import PartObservation
from snapfit.tracking.assembly.link_error import LinkFit, LinkMeasure
from snapfit.tracking.assembly.parameters import AssemblyParameters


class Undoing:
    """Compares where linked parts would be by themselves with where their links have them.

    Args:
        held: links of the state.
        parameters: thresholds.
    """

    def __init__(self, held: Sequence[LinkMeasure], parameters: AssemblyParameters) -> None:
        self._held = held
        self._parameters = parameters
        self._counts = [0] * len(held)
        self._absent = [0] * len(held)
        self._has_agreed = [False] * len(held)
        self._turn = 0
        self._fits: list[LinkFit | None] = [None] * len(held)

    def update(self, observations: Mapping[str, PartObservation]) -> None:
        """Takes in a frame."""
        if self._held:
            self._turn = (self._turn + 1) % len(self._held)
        for i, measure in enumerate(self._held):
            self._miss(i, measure, observations)
            # One link a frame, and those that are in doubt: each is measured every few frames.
            if i != self._turn and self._counts[i] == 0:
                continue
            child = observations.get(measure.link.child)
            parent = observations.get(measure.link.parent)
            if child is None or parent is None or child.is_absent:
                continue
            if child.visibility >= self._parameters.least_visibility:
                self._judge(i, measure, child.free_camera_from_body, parent.camera_from_body)

    def _miss(
        self, i: int, measure: LinkMeasure, observations: Mapping[str, PartObservation]
    ) -> None:
        """Counts a child that is not where its link has it, and is not found elsewhere either."""
        child = observations.get(measure.link.child)
        parent = observations.get(measure.link.parent)
        if child is None or parent is None or not child.is_absent:
            self._absent[i] = max(self._absent[i] - 1, 0)
            return
        if child.camera_from_body is None or parent.camera_from_body is None:
            return
        self._absent[i] += 1
        if self._absent[i] < self._parameters.absent_frames:
            return
        relative = parent.camera_from_body.inverse() @ child.camera_from_body
        self._fits[i] = measure.fit(relative.matrix)
        self._counts[i] = self._parameters.undone_frames

    def contradicted(self, is_held: bool) -> LinkFit | None:
        """The measurement of a link that no longer holds.

        Args:
            is_held: whether an operator's word stands: then a link must have held before.
        """
        for count, fit, has_agreed in zip(self._counts, self._fits, self._has_agreed, strict=True):
            is_long = count >= self._parameters.undone_frames
            if is_long and fit is not None and (has_agreed or not is_held):
                return fit
        return None

    @property
    def progress(self) -> float:
        """How much of what is needed to go back is there, 0 to 1."""
        return min(max(self._counts, default=0) / self._parameters.undone_frames, 1.0)

    def _judge(self, i: int, measure: LinkMeasure, child: Pose | None, parent: Pose | None) -> None:
        """Measures one link where its child would be by itself."""
        if child is None or parent is None:
            return
        share, link = self._parameters.undone_share, measure.link
        fit = measure.fit((parent.inverse() @ child).matrix)
        is_off = not fit.is_within(
            share * link.translation_tolerance_m, share * math.radians(link.rotation_tolerance_deg)
        )
        self._fits[i] = fit if is_off else None
        self._counts[i] = self._counts[i] + 1 if is_off else max(self._counts[i] - 1, 0)
        self._has_agreed[i] |= not is_off
