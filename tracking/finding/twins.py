"""Which of several parts of one mesh lies where: a link has a name for the place."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from itertools import permutations

from snapfit.models.asset import Asset, Part
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.body import Body
from snapfit.tracking.finding.assignment import Assignment
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.link_places import LinkPlaces

_NEAR_M, _NEAR_RAD = 0.008, 0.25
_ROUNDS = 2
_SEEN_SWAPPED = 3


class Twins:
    """Names parts of one mesh: nobody can see which is which, but a link says which is meant.

    Args:
        parts: tracked parts.
        places: that links know for them.
        assignment: of finds to parts.
    """

    def __init__(self, parts: Sequence[Part], places: LinkPlaces, assignment: Assignment) -> None:
        self._places, self._assignment = places, assignment
        self._symmetries = {part.name: part.symmetry for part in parts}
        self._shapes = {part.name: part.mesh.digest for part in parts}
        self._pairs = [
            (one, other)
            for one, other in permutations(self._shapes, 2)
            if self._shapes[one] == self._shapes[other]
        ]
        self._seen = Counter[tuple[str, str]]()

    def exchanged(self, known: Mapping[str, Pose], free: Collection[str]) -> dict[str, Pose]:
        """New poses of two parts of which one has been put where a link has the other.

        Whoever assembles takes one of them, not the one that the manifest names. To be asked now
        and then: only what is so for three times is told.

        Args:
            known: where parts are that are seen.
            free: names of those that nothing links.
        """
        for one, other in self._pairs:
            is_so = (
                one in free
                and other in free
                and {one, other} <= known.keys()
                and self._sits_as(one, known[other], known)
                and not self._sits_as(one, known[one], known)
                and not self._sits_as(other, known[other], known)
            )
            self._seen[one, other] = self._seen[one, other] + 1 if is_so else 0
            if self._seen[one, other] >= _SEEN_SWAPPED:
                self._seen.clear()
                return {one: known[other], other: known[one]}
        return {}

    def _sits_as(self, part: str, pose: Pose, known: Mapping[str, Pose]) -> bool:
        """Whether a pose is one of a part's places beside parts that are no twins of it."""
        shape = self._shapes[part]
        others = {name: it for name, it in known.items() if self._shapes.get(name) != shape}
        return self._places.sits(part, pose, others, _NEAR_M, _NEAR_RAD)

    def named(
        self, found: Sequence[Hypothesis], missing: Sequence[str], there: Mapping[str, Pose]
    ) -> list[Hypothesis]:
        """Finds without those of a twin at a place that a link has for another one.

        Args:
            found: of one look; of twins each at each place.
            missing: names of the parts that are to be found.
            there: where the others are.
        """
        left = list(found)
        for _ in range(_ROUNDS):  # what carries a part may be a twin itself
            placed = {**there, **self._assignment.assign(left, missing, there)}
            own = self._in_their_places(left, missing, placed)
            left = [each for each in left if not self._belongs_to_another(each, own)]
        return left

    def _in_their_places(
        self, found: Sequence[Hypothesis], missing: Sequence[str], placed: Mapping[str, Pose]
    ) -> dict[str, Pose]:
        """Of twins those that were found where a link puts them."""
        own: dict[str, Pose] = {}
        for each in found:
            twins = [it for it in missing if self._shapes[it] == self._shapes.get(each.part)]
            if len(twins) < 2 or each.part not in missing or each.part in own:
                continue
            if self._sits_as(each.part, each.camera_from_body, placed):
                own[each.part] = each.camera_from_body
        return own

    def _belongs_to_another(self, each: Hypothesis, own: Mapping[str, Pose]) -> bool:
        if each.part in own:
            return not self._is_near(each.part, each.camera_from_body, own[each.part])
        shape = self._shapes.get(each.part)
        return any(
            self._shapes[name] == shape and self._is_near(name, each.camera_from_body, pose)
            for name, pose in own.items()
        )

    def _is_near(self, part: str, pose: Pose, other: Pose) -> bool:
        off_m, off_rad = distance_modulo_symmetry(pose, other, self._symmetries[part])
        return bool(off_m < _NEAR_M and off_rad < _NEAR_RAD)


def twins_of(parts: Sequence[Part], bodies: Sequence[Body], asset: Asset | None) -> Twins | None:
    """Those of an asset; None where no two parts have one mesh, or nothing is linked."""
    shapes = [part.mesh.digest for part in parts]
    if asset is None or len(set(shapes)) == len(shapes):
        return None
    return Twins(parts, LinkPlaces(parts, asset.states), Assignment(bodies))
