"""Evidence that a link of the current state no longer holds: its part is somewhere else."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from snapfit.models.pose import Array
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
        self._has_agreed = [False] * len(held)
        self._fits: list[LinkFit | None] = [None] * len(held)

    def update(self, observations: Mapping[str, PartObservation]) -> None:
        """Takes in a frame."""
        for i, measure in enumerate(self._held):
            child = observations.get(measure.link.child)
            parent = observations.get(measure.link.parent)
            if child is None or parent is None or child.free_camera_from_body is None:
                continue
            if child.visibility < self._parameters.least_visibility:
                continue
            self._fits[i] = fit = self._contradiction(measure, child, parent)
            self._counts[i] = max(self._counts[i] - 1, 0) if fit is None else self._counts[i] + 1
            self._has_agreed[i] |= fit is None

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

    def _contradiction(
        self, measure: LinkMeasure, child: PartObservation, parent: PartObservation
    ) -> LinkFit | None:
        """The error of the child's own pose where it is too large for the link."""
        free, linked = child.free_camera_from_body, child.camera_from_body
        if free is None or parent.camera_from_body is None:
            return None
        share, link = self._parameters.undone_share, measure.link
        limit_m = share * link.translation_tolerance_m
        limit_rad = share * math.radians(link.rotation_tolerance_deg)
        # Cheap where it agrees, which is nearly always.
        if linked is not None and _agrees(free.matrix - linked.matrix, limit_m, limit_rad):
            return None
        parent_from_child = parent.camera_from_body.inverse() @ free
        fit = measure.fit(parent_from_child.matrix)
        return None if fit.is_within(limit_m, limit_rad) else fit


def _agrees(difference: Array, limit_m: float, limit_rad: float) -> bool:
    """Whether two poses, given their difference (4, 4), surely lie within half of both limits."""
    moved, turned = difference[:3, 3], difference[:3, :3].ravel()
    # The Frobenius norm of a difference of rotations is sqrt(8) sin(angle / 2).
    is_moved_little = bool(moved @ moved < (limit_m / 2) ** 2)
    return is_moved_little and bool(turned @ turned < 8 * math.sin(min(limit_rad, 3.0) / 4) ** 2)
