"""Gives finds to parts: one part at a place, and parts that look alike share their finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.recovery.taken import TakenPlaces


class Assignment:
    """Assigns hypotheses, the surest first.

    Args:
        bodies: all that are tracked.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._index = {body.name: i for i, body in enumerate(bodies)}
        self._shapes = {body.name: body.mesh.digest for body in bodies}
        self._taken = TakenPlaces(bodies)

    def found_as(self, findable: Sequence[str]) -> dict[str, tuple[str, ...]]:
        """By part, the names under which a finder finds it: its own, or those of its like.

        None for parts that it cannot find.

        Args:
            findable: names of the parts that the finder knows.
        """
        alike = {
            name: tuple(each for each in findable if self._shapes.get(each) == shape)
            for name, shape in self._shapes.items()
        }
        return {name: (name,) if name in findable else alike[name] for name in self._shapes}

    def assign(
        self,
        hypotheses: Sequence[Hypothesis],
        searched: Sequence[str],
        known: Mapping[str, Pose],
    ) -> dict[str, Pose]:
        """Where searched parts are.

        Args:
            hypotheses: of one look.
            searched: names of the parts that are to be given places.
            known: where other parts are; nothing else is there.

        Returns:
            by part, for as many as there are places.
        """
        there = {self._index[name]: pose for name, pose in known.items()}
        places: dict[str, Pose] = {}
        for each in sorted(hypotheses, key=lambda hypothesis: -hypothesis.score):
            part = self._part_for(each.part, [name for name in searched if name not in places])
            if part is None:
                continue
            body = self._index[part]
            if not self._taken.is_taken(body, each.camera_from_body, there):
                places[part] = there[body] = each.camera_from_body
        return places

    def _part_for(self, found: str, free: Sequence[str]) -> str | None:
        """The part itself, or one of the same shape that still has no place."""
        if found in free:
            return found
        shape = self._shapes.get(found)
        return next((name for name in free if self._shapes[name] == shape), None)
