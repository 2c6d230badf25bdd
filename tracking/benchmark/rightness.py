"""Whether poses are right: ADD(-S) under 10 % of the diameter, of all parts that can be seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations

from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.tracking.metrics import add_m, add_s_m, model_vertices

RIGHT_SHARE = 0.1
"""Of the diameter: a pose with a smaller ADD(-S) is right."""

LEAST_SEEN = 0.3
"""Of a part's outline: of parts of which less is seen no pose is asked."""


class PoseError:
    """ADD-S of a symmetric part, ADD of any other, with all that does not change made once.

    Attributes:
        diameter_m: of the part.
    """

    def __init__(self, part: Part) -> None:
        self.diameter_m = part.mesh.diameter_m
        self._sample = model_vertices(part.mesh)
        # ADD needs no closest points.
        self._tree = None if part.symmetry.is_none else cKDTree(model_vertices(part.mesh, None))

    def add_m(self, estimate: Pose, truth: Pose) -> float:
        """ADD(-S) of a pose, m; both are `camera_from_body`."""
        if self._tree is None:
            return add_m(self._sample, estimate, truth)
        return add_s_m(self._sample, estimate, truth, self._tree)

    def is_right(self, estimate: Pose | None, truth: Pose) -> bool:
        """Whether a pose is right; none is not."""
        return estimate is not None and self.add_m(estimate, truth) < RIGHT_SHARE * self.diameter_m


class Rightness:
    """Judges the poses of all parts of a frame together.

    Args:
        parts: that are tracked.
        interchangeable: whether parts of one mesh may stand for each other: who sees them for the
            first time cannot tell which is which.
    """

    def __init__(self, parts: Sequence[Part], *, interchangeable: bool) -> None:
        self._errors = {part.name: PoseError(part) for part in parts}
        groups: dict[str, list[str]] = {}
        for part in parts:
            groups.setdefault(part.mesh.digest if interchangeable else part.name, []).append(
                part.name
            )
        self._groups = list(groups.values())

    def shows(self, truth: GroundTruth) -> bool:
        """Whether enough is seen of any part: a frame that shows none tells nothing."""
        return any(truth.visibility.get(name, 1.0) >= LEAST_SEEN for name in self._errors)

    def wrong(self, estimates: Mapping[str, Pose | None], truth: GroundTruth) -> tuple[str, ...]:
        """The parts that can be seen and have no right pose.

        Args:
            estimates: `camera_from_body` by part; None or nothing where there is none.
            truth: of the frame; a part of unknown visibility counts as seen.
        """
        return tuple(
            name for group in self._groups for name in self._wrong_of(group, estimates, truth)
        )

    def _wrong_of(
        self, group: Sequence[str], estimates: Mapping[str, Pose | None], truth: GroundTruth
    ) -> list[str]:
        """Of parts of one mesh those that are wrong, in the assignment with the fewest of them."""
        seen = [name for name in group if truth.visibility.get(name, 1.0) >= LEAST_SEEN]
        fewest = seen
        for order in permutations(group, len(seen)):
            wrong = [
                name
                for name, other in zip(seen, order, strict=True)
                if not self._errors[name].is_right(
                    estimates.get(other), truth.camera_from_body[name]
                )
            ]
            if len(wrong) < len(fewest):
                fewest = wrong
        return fewest
