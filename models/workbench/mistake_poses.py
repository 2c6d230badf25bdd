"""Where a part may be put wrongly: it touches what is assembled, and goes through nothing.

World frame as in `script`. A part is pushed along a line until it first touches, so that nothing
overlaps, whatever the shapes are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Link
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.clearance import Clearance
from snapfit.models.workbench.mistake import MistakeKind
from snapfit.models.workbench.mounting import Mount, joined

_TOUCH_M, _REACH_M, _BACK_M = 0.0006, 0.25, 0.04
# Distances are measured no farther than this: that is quick.
_LOOK_AHEAD_M = 0.006
_ADVANCES, _TRIES = 80, 24
_BESIDE_M = (0.02, 0.065)
_CLEAR = 0.02
# The middle of a part that is at the right place, but turned, is as near to where it belongs as
# this share of its size; that of another part in its place, of both parts' mean size.
_TURNED_SHARE, _OTHER_SHARE, _NEAR_M = 0.25, 0.2, 0.012
_LIKE_SIZE = 2.6
_LEVER_M = 0.1
# A turned part that shares more of its volume with itself unturned looks nearly the same.
_ALIKE = 0.85


@dataclass(frozen=True, eq=False)
class Setting:
    """The bench before a mistake.

    Attributes:
        asset: whose parts are there.
        state: assembly state.
        links: of that state.
        poses: `world_from_part` of all parts.
        root: the part that carries the others in the end.
        next: what the next step brings together.
        later: what the steps after it do.
    """

    asset: Asset
    state: str
    links: Sequence[Link]
    poses: Mapping[str, Pose]
    root: str
    next: Sequence[Mount]
    later: Sequence[Mount]

    @property
    def module(self) -> frozenset[str]:
        """Names of the parts that are joined to the root, and the root's."""
        return frozenset(joined(self.root, self.links))

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the tracked parts that are joined to nothing; never the root."""
        ends = {name for link in self.links for name in (link.parent, link.child)}
        tracked = [part.name for part in self.asset.tracked_parts]
        return tuple(name for name in tracked if name not in ends and name != self.root)


@dataclass(frozen=True, eq=False)
class Coming:
    """A free part that is to be brought to the module.

    Attributes:
        mount: how.
        part: that is brought; the child, or the parent where the child belongs to the module.
        other: of the module.
        seat: `world_from_part` in its place.
        direction: (3,) unit, world frame: from which side it comes.
    """

    mount: Mount
    part: str
    other: str
    seat: Pose
    direction: Array


@dataclass(frozen=True, eq=False)
class WrongPose:
    """A part at rest where it does not belong.

    Attributes:
        kind: in what way.
        part: its name.
        parent: what it touches, or would be linked to.
        goal: `world_from_part`.
        back_m: (3,) world frame, back along the straight way on which it comes.
        translation_m: how far it is from its own place; infinite where it has none in the module.
        rotation_rad: likewise.
    """

    kind: MistakeKind
    part: str
    parent: str
    goal: Pose
    back_m: Array
    translation_m: float
    rotation_rad: float


class WrongPoses:
    """Finds wrong poses for one setting.

    Args:
        setting: the bench.
        clearance: of all parts.
        rng: of all choices.
    """

    def __init__(self, setting: Setting, clearance: Clearance, rng: np.random.Generator) -> None:
        self._setting, self._clearance, self._rng = setting, clearance, rng
        self._parts = {part.name: part for part in setting.asset.parts}
        self._module = {name: setting.poses[name] for name in sorted(setting.module)}
        self._next = list(self._coming(setting.next))

    def of(self, kind: MistakeKind) -> Iterator[WrongPose]:
        """Wrong poses of a kind, the better ones first; none where geometry does not allow it."""
        match kind:
            case MistakeKind.WRONG_PLACE:
                found = self._beside()
            case MistakeKind.WRONG_WAY_ROUND:
                found = self._turned()
            case MistakeKind.WRONG_PART:
                found = self._another()
            case MistakeKind.WRONG_ORDER:
                found = self._too_early()
        for part, goal, direction in found:
            wrong = self._checked(kind, part, goal, direction)
            if wrong is not None:
                yield wrong

    def _coming(self, mounts: Sequence[Mount]) -> Iterator[Coming]:
        setting = self._setting
        for mount in mounts:
            link = mount.link
            if link.child in setting.free and link.parent in setting.module:
                base = setting.poses[link.parent]
                seat, way = base @ link.parent_from_child, base.rotation @ mount.direction
                yield Coming(mount, link.child, link.parent, seat, way)
            elif link.parent in setting.free and link.child in setting.module:
                base = setting.poses[link.child]
                seat = base @ link.parent_from_child.inverse()
                yield Coming(mount, link.parent, link.child, seat, -seat.rotation @ mount.direction)

    def _beside(self) -> Iterator[tuple[str, Pose, Array]]:
        """Next to where it belongs, some centimetres away, slightly askew."""
        for coming in self._next:
            for i in range(_TRIES):
                way = self._unit() if i >= _TRIES // 2 else coming.direction
                way = np.array([way[0], way[1], abs(way[2])])
                side = np.cross(way, self._unit())
                side *= self._rng.uniform(*_BESIDE_M) / np.linalg.norm(side)
                askew = self._about_middle(coming.part, 0.15 * self._rng.standard_normal(3))
                start = Pose.from_translation(*side) @ coming.seat @ askew
                goal = self._pushed(coming.part, start, way, 0.03)
                if goal is not None:
                    yield coming.part, goal, way

    def _turned(self) -> Iterator[tuple[str, Pose, Array]]:
        """At its place, turned by one to three quarters about an axis of its own."""
        for coming in self._next:
            limit_m = max(_TURNED_SHARE * self._parts[coming.part].mesh.diameter_m, _NEAR_M)
            for i in self._rng.permutation(9):
                turn = (i // 3 + 1) * math.pi / 2 * np.eye(3)[i % 3]
                turned = self._about_middle(coming.part, turn)
                if self._clearance.common_share(coming.part, turned) > _ALIKE:
                    continue
                start = coming.seat @ turned
                goal = self._pushed(coming.part, start, coming.direction, 0.0)
                if goal is not None and goal.distance_to(start) < limit_m:
                    yield coming.part, goal, coming.direction

    def _another(self) -> Iterator[tuple[str, Pose, Array]]:
        """Another part, neither much smaller nor larger, at the place of the next one."""
        for coming in self._next:
            own = self._parts[coming.part].mesh
            for name in self._rng.permutation(self._setting.free):
                mesh = self._parts[str(name)].mesh
                sizes = sorted((mesh.diameter_m, own.diameter_m))
                if mesh.digest == own.digest or sizes[1] > _LIKE_SIZE * sizes[0]:
                    continue
                limit_m = max(_OTHER_SHARE * sum(sizes) / 2, _NEAR_M)
                middle = coming.seat.transform(own.center_m.astype(np.float64))
                for i in self._rng.permutation(12):
                    turn = (i // 3) * math.pi / 2 * np.eye(3)[i % 3]
                    rotation = coming.seat.rotation @ Pose.exp([*turn, 0, 0, 0]).rotation
                    origin = middle - rotation @ mesh.center_m.astype(np.float64)
                    start = Pose.from_rotation_translation(rotation, origin)
                    goal = self._pushed(str(name), start, coming.direction, 0.0)
                    if goal is not None and goal.distance_to(start) < limit_m:
                        yield str(name), goal, coming.direction

    def _too_early(self) -> Iterator[tuple[str, Pose, Array]]:
        """A part in its own place, though another one belongs there before it."""
        soon = {coming.part for coming in self._next}
        options = [each for each in self._coming(self._setting.later) if each.part not in soon]
        for i in self._rng.permutation(len(options)):
            yield options[i].part, options[i].seat, options[i].direction

    def _pushed(self, part: str, pose: Pose, way: Array, past_m: float) -> Pose | None:
        """Brought along a line until it touches the module.

        Args:
            part: its name.
            pose: `world_from_part` towards which it is pushed.
            way: (3,) unit, from which side.
            past_m: how far beyond the pose it may go.

        Returns:
            None where it has not touched by then.
        """
        away_m = _REACH_M
        for _ in range(_ADVANCES):
            here = Pose.from_translation(*(away_m * way)) @ pose
            gap_m = self._clearance.gap_m({part: here}, self._module, _LOOK_AHEAD_M)
            if gap_m < _TOUCH_M:
                return here if gap_m > 0 else None
            if away_m <= -past_m:
                return None
            # It cannot touch before it has come nearer by the gap.
            away_m = max(away_m - gap_m + _TOUCH_M / 2, -past_m)
        return None

    def _checked(self, kind: MistakeKind, part: str, goal: Pose, way: Array) -> WrongPose | None:
        """A wrong pose, unless it is right after all or the part goes through something."""
        setting = self._setting
        parent = self._nearest(part, goal)
        others = {name: pose for name, pose in setting.poses.items() if name != part}
        if kind is MistakeKind.WRONG_ORDER:
            # In its own place a thread may lie in the other's, as it does when all is right.
            del others[parent]
        back_m = _BACK_M * way
        stretch = [Pose.from_translation(*(share * back_m)) @ goal for share in (0, 0.4, 1)]
        if self._clearance.worst(stretch, {part: Pose.identity()}, others) > _CLEAR:
            return None
        off = [self._off(goal, link) for link in self._links_of(part)]
        if kind is not MistakeKind.WRONG_ORDER:
            for link, (way_m, turn_rad) in zip(self._links_of(part), off, strict=True):
                is_turned = math.degrees(turn_rad) > 2 * link.rotation_tolerance_deg
                far_m = max(link.translation_tolerance_m, _BESIDE_M[0])
                if not is_turned and way_m < far_m:
                    return None
                if kind is MistakeKind.WRONG_WAY_ROUND and not is_turned:
                    return None
                # Near its own place it would be turned, not misplaced.
                if kind is not MistakeKind.WRONG_WAY_ROUND and way_m < far_m:
                    return None
        way_m, turn_rad = min(off, default=(math.inf, math.inf))
        return WrongPose(kind, part, parent, goal, back_m, way_m, turn_rad)

    def _links_of(self, part: str) -> list[Link]:
        """Links that a part, or one of the same shape, may have to the module in some state."""
        digest = self._parts[part].mesh.digest
        twins = {name for name, each in self._parts.items() if each.mesh.digest == digest}
        found: list[Link] = []
        for state in self._setting.asset.states:
            for link in state.links:
                own, other = link.child, link.parent
                if own not in twins:
                    own, other = other, own
                known = any(
                    each.parent_from_child.distance_to(link.parent_from_child) < 1e-6
                    and (each.parent, each.child) == (link.parent, link.child)
                    for each in found
                )
                if own in twins and other in self._setting.module and not known:
                    found.append(link)
        return found

    def _off(self, goal: Pose, link: Link) -> tuple[float, float]:
        """How far a part is from a link, its own or its twin's: m and rad, freedom taken out."""
        is_child = link.child not in self._setting.module
        other = link.parent if is_child else link.child
        apart = self._setting.poses[other].inverse() @ goal
        parent_from_child = apart if is_child else apart.inverse()
        child, parent = (self._looks(name) for name in (link.child, link.parent))
        joint = JointMotion.of(link)
        zero = joint.zero.inverse()
        lefts = np.stack([(zero @ each.inverse()).matrix for each in parent])
        rights = np.stack([(parent_from_child @ each).matrix for each in child])
        candidates = (lefts[:, None] @ rights[None]).reshape(-1, 4, 4)
        _, way_m, turn_rad = joint.closest_of(candidates)
        best = int((way_m + _LEVER_M * turn_rad).argmin())
        return float(way_m[best]), float(turn_rad[best])

    def _looks(self, name: str) -> tuple[Pose, ...]:
        """Motions that leave a part as it looks; what is joined to it leaves it none."""
        part = self._parts[name]
        if name in self._setting.module and len(self._setting.module) > 1:
            return (Pose.identity(),)
        return part.symmetry.sampled(0.004, part.mesh.diameter_m / 2)

    def _nearest(self, part: str, goal: Pose) -> str:
        moving = {part: goal}
        gaps_m = {
            name: self._clearance.gap_m(moving, {name: pose}, _LOOK_AHEAD_M)
            for name, pose in self._module.items()
        }
        return min(gaps_m, key=lambda name: gaps_m[name])

    def _about_middle(self, part: str, turn: Array) -> Pose:
        """A turn, rotation vector (3,), of a part about its own middle."""
        middle = self._parts[part].mesh.center_m.astype(np.float64)
        rotation = Pose.exp([*turn, 0, 0, 0]).rotation
        return Pose.from_rotation_translation(rotation, middle - rotation @ middle)

    def _unit(self) -> Array:
        direction: Array = self._rng.standard_normal(3)
        return direction / np.linalg.norm(direction)
