"""Where the links of an assembly would put a part, beside the parts that are known."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from snapfit.models.asset import Part
from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Link, State
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import Symmetry, SymmetryAxis
from snapfit.tracking.assembly.graph import has_link

_STEP_M, _STEP_RAD = 0.01, math.radians(20)
"""From one place on a joint to the next: a refinement finds what lies between."""
_SAME_M, _SAME_RAD = 0.004, math.radians(8)
_FREE_TRAVEL_M = 0.05


class LinkPlaces:
    """All places that the states of an assembly know, joints in steps over their range.

    Args:
        parts: tracked parts.
        states: of the assembly graph.
    """

    def __init__(self, parts: Sequence[Part], states: Iterable[State]) -> None:
        by_name = {part.name: part for part in parts}
        links: list[Link] = []
        for link in (each for state in states for each in state.links):
            is_tracked = link.parent in by_name and link.child in by_name
            if is_tracked and not has_link(links, link):
                links.append(link)
        found: dict[tuple[str, str], list[Pose]] = {}
        for link in links:
            parent, child = by_name[link.parent], by_name[link.child]
            placed = list(_along(link))
            found.setdefault((link.parent, link.child), []).extend(_beside(parent, placed))
            inverses = [each.inverse() for each in placed]
            found.setdefault((link.child, link.parent), []).extend(_beside(child, inverses))
        self._symmetries = {part.name: part.symmetry for part in parts}
        self._places = {
            (known, wanted): _different(places, by_name[wanted].symmetry)
            for (known, wanted), places in found.items()
        }

    def beside(self, known: str, wanted: str) -> tuple[Pose, ...]:
        """`known_from_wanted` of all places of a part on a known one; empty where none links them.

        Poses that look the same are in it once; the known part may stand in any of those in which
        it looks the same.
        """
        return self._places.get((known, wanted), ())

    def sits(
        self, part: str, pose: Pose, known: Mapping[str, Pose], near_m: float, near_rad: float
    ) -> bool:
        """Whether a part at a pose is in one of its places beside the known ones.

        Args:
            part: its name.
            pose: `camera_from_body` of it.
            known: the same of the others.
            near_m, near_rad: how near; between two steps of a joint half a step is not near.
        """
        symmetry = self._symmetries[part]
        motions = _motions(symmetry)
        return any(
            _any_same(
                (other.inverse() @ pose).matrix @ motions,
                np.stack([place.matrix for place in places]),
                symmetry.axis,
                (near_m, near_rad),
            )
            for name, other in known.items()
            if (places := self.beside(name, part))
        )

    def of(self, wanted: str, known: Mapping[str, Pose]) -> list[Pose]:
        """`camera_from_wanted` of all places of a part beside the known ones."""
        return [pose @ place for name, pose in known.items() for place in self.beside(name, wanted)]


def _beside(known: Part, places: Iterable[Pose]) -> list[Pose]:
    """Places beside a part in all poses in which it looks the same."""
    radius_m = known.mesh.diameter_m / 2
    motions = known.symmetry.sampled(_STEP_RAD * radius_m, radius_m)
    return [motion @ place for place in places for motion in motions]


def _different(places: Sequence[Pose], symmetry: Symmetry) -> tuple[Pose, ...]:
    """Places of a part, of those that look the same the first."""
    motions = _motions(symmetry)
    kept: list[Pose] = []
    known = np.zeros((0, 4, 4))
    for place in places:
        alike = place.matrix @ motions
        if not _any_same(alike, known, symmetry.axis, (_SAME_M, _SAME_RAD)):
            kept.append(place)
            known = np.concatenate([known, place.matrix[None]])
    return tuple(kept)


def _motions(symmetry: Symmetry) -> Array:
    """(M, 4, 4) discrete motions, the identity first."""
    return np.stack([Pose.identity().matrix, *(each.matrix for each in symmetry.motions)])


def _any_same(
    alike: Array, known: Array, axis: SymmetryAxis | None, near: tuple[float, float]
) -> bool:
    """Whether one of (M, 4, 4) poses is near one of (N, 4, 4), by m and rad.

    Turns about an axis of symmetry do not count.
    """
    one, other = alike[:, None], known[None]
    if axis is None:
        apart = one[..., :3, 3] - other[..., :3, 3]
        trace = (one[..., :3, :3] * other[..., :3, :3]).sum(axis=(-2, -1))
        cosine = (trace - 1) / 2
    else:
        apart = (one - other)[..., :3, :3] @ axis.point_m + (one - other)[..., :3, 3]
        first, second = one[..., :3, :3] @ axis.direction, other[..., :3, :3] @ axis.direction
        cosine = (first * second).sum(axis=-1)
    is_near = (apart * apart).sum(axis=-1) < near[0] ** 2
    return bool((is_near & (cosine > math.cos(near[1]))).any())


def _along(link: Link) -> Iterator[Pose]:
    """`parent_from_child` along the joint of a link, the joint's zero first."""
    joint = JointMotion.of(link)
    yield joint.zero
    ranges = [_steps(joint, i) for i in range(joint.n_dof)]
    for q in itertools.product(*ranges) if ranges else ():
        yield joint.parent_from_child(np.array(q))


def _steps(joint: JointMotion, coordinate: int) -> Array:
    """Values of a coordinate, even over its range."""
    low, high = joint.limits[coordinate]
    turns = joint.type.turns and coordinate == 0
    step = _STEP_RAD if turns else _STEP_M
    widest = math.pi if turns else _FREE_TRAVEL_M
    if not math.isfinite(low):
        low = (high if math.isfinite(high) else widest) - 2 * widest
    if not math.isfinite(high):
        high = low + 2 * widest
    count = max(2, math.ceil((high - low) / step) + 1) if high > low else 1
    values: Array = np.linspace(low, high, count)
    return values
