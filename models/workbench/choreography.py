"""Motions one after the other: each part is taken, looked at, brought to its place and put in.

What is joined moves as one; now and then the whole is taken up and turned. World frame as in
`script`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from snapfit.models.manifest import JointType, Link, Step
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.clearance import Clearance
from snapfit.models.workbench.layout import root_of
from snapfit.models.workbench.motion import Motion, Slide, Swing, Tremor, Twist
from snapfit.models.workbench.mounting import Mount, joined
from snapfit.models.workbench.script import Move, Script
from snapfit.models.workbench.split import FRAME_RATE_HZ

_REST, _GAP = 14, 11
_AIR_X_M, _AIR_Y_M, _AIR_Z_M = (-0.15, 0.15), (-0.12, 0.10), (0.10, 0.19)
_PEAK_M = 0.0115
_TWIST_FRAMES, _TWIST_RAD = 20, math.radians(75)
_SUB_FRAMES = 30
_LIFT_M, _CARRY_FRAMES = 0.09, (26, 46)
_TURN_WEIGHT, _UNTRACKED_WEIGHT = 0.6, 0.45
# Ways through the air that are tried until one is clear, each higher than the one before.
_TRIES, _HIGHER_M = 6, 0.04
_CLEAR, _CEILING_M = 0.03, 0.31
# A hinge may be put in turned by these shares of a twist; the first that is clear is taken.
_TURNS = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25)
_DURING = tuple((i + 0.5) / 12 for i in range(12))


@dataclass(frozen=True)
class Pace:
    """How fast a part is moved about while it is looked at: mean of a motion, by frame."""

    step_m: float = 0.003
    turn_rad: float = math.radians(1.5)


@dataclass(frozen=True, eq=False)
class Bodies:
    """The parts' shapes.

    Attributes:
        outer: (N, 3) vertices of each part's convex hull, which decide how high it stands.
        clearance: of all of them.
    """

    outer: Mapping[str, Array]
    clearance: Clearance

    @staticmethod
    def of(meshes: Mapping[str, Mesh]) -> Bodies:
        """Of meshes by part, closed."""
        outer = {name: _hull_points(mesh) for name, mesh in meshes.items()}
        return Bodies(outer, Clearance(meshes, outer))


class Choreographer:
    """Puts motions one after the other."""

    def __init__(
        self,
        first_state: str,
        tracked: frozenset[str],
        bodies: Bodies,
        initial: Mapping[str, Pose],
        plan: Sequence[tuple[Step, tuple[Mount, ...]]],
        pace: Pace,
        seed: int,
        links: Sequence[Link] = (),
    ) -> None:
        self._tracked, self._bodies = tracked, bodies
        self._plan = plan
        self._pace = pace
        self._rng = np.random.default_rng((seed, 1))
        self._initial = dict(initial)
        self._now = dict(initial)
        self._links: list[Link] = list(links)
        self._root = root_of([mount.link for _, mounts in plan for mount in mounts])
        self._moves: list[Move] = []
        self._states = [(0.0, first_state)]
        self._frame = _REST

    def play(self, n_frames: int) -> Script:
        """The assembly in so many frames."""
        n_mounts = sum(len(mounts) for _, mounts in self._plan)
        n_turns = max(1, round(n_frames / 300))
        turned_after = {round((i + 1) * n_mounts / n_turns) for i in range(n_turns)}
        weights = []
        for i, mount in enumerate((m for _, mounts in self._plan for m in mounts), start=1):
            weights.append(1.0 if mount.link.child in self._tracked else _UNTRACKED_WEIGHT)
            weights += [_TURN_WEIGHT] if i in turned_after else []
        ends = _REST - _GAP + np.cumsum(weights) / sum(weights) * (n_frames - 2 * _REST + _GAP)
        entry = n_done = 0
        for step, mounts in self._plan:
            for each in mounts:
                self._mount(each, max(round(ends[entry]) - self._frame, 6))
                self._links.append(each.link)
                entry, n_done = entry + 1, n_done + 1
                if each is mounts[-1]:
                    self._states.append((self._frame / FRAME_RATE_HZ, step.to_state))
                self._frame += _GAP
                if n_done in turned_after:
                    self._turn_whole(max(round(ends[entry]) - self._frame, 6))
                    self._frame += _GAP
                    entry += 1
        duration_s = (n_frames - 1) / FRAME_RATE_HZ
        return Script(self._initial, tuple(self._moves), tuple(self._states), duration_s)

    def carry(self, part: str, goal: Pose, back_m: Array, n_rest: int) -> Script:
        """One part brought to any place and left there, instead of the assembly.

        Args:
            part: its name.
            goal: `world_from_part`.
            back_m: (3,) from the goal back along the straight last stretch, world frame.
            n_rest: frames at the end in which nothing moves.
        """
        before = Pose.from_translation(*back_m) @ goal
        length_m = self._now[part].distance_to(before) + _LIFT_M
        n_way = int(np.clip(round(1.875 * length_m / _PEAK_M), *_CARRY_FRAMES))
        self._swing(part, before, n_way, lift_m=_LIFT_M)
        self._add(part, Slide(before, goal), _sliding_frames(back_m, n_way))
        duration_s = (self._frame + n_rest - 1) / FRAME_RATE_HZ
        return Script(self._initial, tuple(self._moves), tuple(self._states), duration_s)

    def _mount(self, mount: Mount, n: int) -> None:
        link = mount.link
        ends = (link.parent, link.child)
        self._links = [each for each in self._links if (each.parent, each.child) != ends]
        own, others = joined(link.child, self._links), joined(link.parent, self._links)
        if link.parent in own:
            return
        if self._root in own or (self._root not in others and len(own) > len(others)):
            part, other, goal = link.parent, link.child, link.parent_from_child.inverse()
            turn = -link.parent_from_child.rotation.T
        else:
            part, other, goal = link.child, link.parent, link.parent_from_child
            turn = np.eye(3)
        back_m, slide_m = turn @ mount.back_m, turn @ mount.slide_m
        n -= self._make_room(part, other, goal, back_m + slide_m, n)
        place = self._now[other]
        slide_m, back_m = place.rotation @ slide_m, place.rotation @ back_m
        if self._is_beside(part, place @ goal):
            self._add(part, Slide(self._now[part], place @ goal), min(n, 40))
        else:
            self._bring(part, place @ goal, (back_m, slide_m), link, n)

    def _is_beside(self, part: str, goal: Pose) -> bool:
        """Whether a part only has to be pushed on."""
        now = self._now[part]
        return now.distance_to(goal) < 0.15 and now.angle_to(goal) < 0.02

    def _make_room(self, part: str, other: str, goal_in_other: Pose, back_m: Array, n: int) -> int:
        """Lifts what the part comes to, where there is no room for it above the bench."""
        low = 0.0
        for shift in (np.zeros(3), back_m):
            goal = self._now[other] @ Pose.from_translation(*shift) @ goal_in_other
            low = min(low, self._lowest_m(part, goal))
        if low > -0.003:
            return 0
        used = min(18, n // 4)
        pose = Pose.from_translation(0, 0, 0.006 - low) @ self._now[other]
        self._swing(other, pose, used)
        return used

    def _bring(
        self, part: str, goal: Pose, ways_m: tuple[Array, Array], link: Link, n: int
    ) -> None:
        """Brings a part along its last stretches, given as ways back from the goal."""
        start, joint = self._now[part], link.joint
        back_m, slide_m = ways_m
        n_twists = 0
        if joint.type.turns:
            n_twists = (3 if n >= 150 else 2) if joint.type is JointType.SCREW and n >= 70 else 1
        n_turning = min(_TWIST_FRAMES * n_twists, n // 3)
        twist, seat = None, Pose.from_translation(*slide_m) @ goal
        if n_twists:
            reach_m = float(np.linalg.norm(back_m))
            shares = (1.0,) if joint.pitch_m else _TURNS
            twists = [
                self._twist(part, goal, back_m / reach_m, link, n_twists, share) for share in shares
            ]
            twist = self._clearest(part, twists, back_m)
            seat = twist.at(0.0)
            back_m = back_m * max(1 - seat.distance_to(goal) / reach_m, 0.1)
        before = Pose.from_translation(*back_m) @ seat
        n_in, n_along = (_sliding_frames(way_m, n) for way_m in (back_m, slide_m))
        self._approach(part, start, before, n - n_turning - n_in - n_along)
        self._add(part, Slide(before, seat), n_in)
        if n_along:
            self._add(part, Slide(seat, goal), n_along)
        if twist is not None:
            self._add(part, twist, n_turning)

    def _clearest(self, part: str, options: Sequence[Twist], back_m: Array) -> Twist:
        """The first twist of those that goes through the least, with the stretch before it."""

        def cost(twist: Twist) -> float:
            seat = twist.at(0.0)
            on_the_way = [twist.at(share) for share in (0.3, 0.6)]
            coming = [Pose.from_translation(*(share * back_m)) @ seat for share in (0, 0.5, 1)]
            return round(self._worst(part, on_the_way + coming), 2)

        return options[0] if len(options) == 1 else min(options, key=cost)

    def _worst(self, part: str, ways: Sequence[Pose]) -> float:
        module = joined(part, self._links)
        standing = {name: pose for name, pose in self._now.items() if name not in module}
        return self._bodies.clearance.worst(ways, module, standing)

    def _twist(
        self, part: str, goal: Pose, back: Array, link: Link, n_twists: int, share: float
    ) -> Twist:
        """The last turns of a joint, about the mover's own axis, drawing in along the joint."""
        joint = link.joint
        axis = np.array(joint.axis, dtype=np.float64)
        point = np.array(joint.point_m)
        if part != link.child:
            axis = link.parent_from_child.rotation @ axis
            point = link.parent_from_child.transform(point)
        axis /= np.linalg.norm(axis)
        pitch_m = joint.pitch_m or 0.0
        along = float((goal.rotation @ axis) @ back)
        if along * (pitch_m or 1.0) > 0:
            axis = -axis
        x, y, z = (float(value) for value in point)
        turn_rad = share * n_twists * _TWIST_RAD
        return Twist(goal, axis, turn_rad, pitch_m, n_twists, point_m=(x, y, z))

    def _approach(self, part: str, start: Pose, before: Pose, n: int) -> None:
        """From the bench, past some places in the air, to where the last stretch begins."""
        length_m = float(np.linalg.norm(before.translation - start.translation)) + 0.08
        n_carry = min(round(1.875 * length_m / _PEAK_M), n)
        n_subs = round((n - n_carry) / _SUB_FRAMES)
        if n_subs < 1:
            self._swing(part, before, n, lift_m=_LIFT_M)
            return
        n_sub = (n - n_carry) // n_subs
        stations = [before]
        for _ in range(n_subs):
            stations.insert(0, self._aside(part, stations[0], n_sub))
        self._swing(part, stations[0], n - n_subs * n_sub, lift_m=_LIFT_M)
        for station in stations[1:]:
            self._swing(part, station, n_sub)

    def _turn_whole(self, n: int) -> None:
        """Takes up what is assembled so far, turns it about, and puts it back."""
        home = self._now[self._root]
        n_subs = max(round(n / _SUB_FRAMES), 2)
        n_sub = n // n_subs
        stations = [home]
        for _ in range(n_subs - 1):
            stations.insert(0, self._aside(self._root, stations[0], n_sub))
        for station in stations:
            self._swing(self._root, station, n_sub)

    def _aside(self, part: str, pose: Pose, n: int) -> Pose:
        """A pose in the air, clear of the rest, about as far away as the pace goes in n frames."""
        poses, costs = [], []
        for _ in range(_TRIES):
            poses.append(self._sampled_aside(part, pose, n))
            costs.append(self._worst(part, poses[-1:]))
            if costs[-1] < _CLEAR:
                break
        return poses[int(np.argmin(costs))]

    def _sampled_aside(self, part: str, pose: Pose, n: int) -> Pose:
        low = np.array([_AIR_X_M[0], _AIR_Y_M[0], _AIR_Z_M[0]])
        high = np.array([_AIR_X_M[1], _AIR_Y_M[1], _AIR_Z_M[1]])
        ways = self._rng.standard_normal((40, 3)) * (1, 1, 0.6)
        ways *= self._pace.step_m * n / np.linalg.norm(ways, axis=1, keepdims=True)
        ends = pose.translation + ways
        outside = np.maximum(np.maximum(low - ends, ends - high), 0).sum(axis=1)
        axis = self._rng.standard_normal(3)
        turn = axis / np.linalg.norm(axis) * self._pace.turn_rad * n
        rotation = pose.rotation @ Pose.exp([*turn, 0, 0, 0]).rotation
        moved = Pose.from_rotation_translation(rotation, ends[int(outside.argmin())])
        lowest = self._lowest_m(part, moved)
        return Pose.from_translation(0, 0, max(0.012 - lowest, 0.0)) @ moved

    def _lowest_m(self, part: str, pose: Pose) -> float:
        """The lowest point above the bench of a part and all that is joined to it."""
        module = joined(part, self._links)
        return min(
            float((pose @ other).transform(self._bodies.outer[name])[:, 2].min())
            for name, other in module.items()
        )

    def _swing(self, part: str, goal: Pose, n: int, lift_m: float = 0.0) -> None:
        """Moves a part freely to a goal, higher if need be, so that it goes through nothing."""
        swings, costs = [], []
        for i in range(_TRIES):
            swing = self._sampled_swing(part, goal, n, lift_m + i * _HIGHER_M)
            swings.append(swing)
            ways = [swing.at(share) for share in _DURING]
            costs.append(self._worst(part, ways) + self._haste(part, swing, ways, n))
            if costs[-1] < _CLEAR:
                break
        self._add(part, swings[int(np.argmin(costs))], n)

    def _haste(self, part: str, swing: Swing, ways: Sequence[Pose], n: int) -> float:
        """What is to be said against a way because it is too high for the camera, or too long."""
        points = self._bodies.outer[part]
        highest_m = max(float(way.transform(points)[:, 2].max()) for way in ways)
        peak_m = 1.875 * float(swing.curve[0][-1]) / n
        return 5 * max(highest_m - _CEILING_M, 0.0) + 50 * max(peak_m - 1.25 * _PEAK_M, 0.0)

    def _sampled_swing(self, part: str, goal: Pose, n: int, lift_m: float) -> Swing:
        start = self._now[part]
        way = goal.translation - start.translation
        side = self._rng.standard_normal(3) * 0.12 * float(np.linalg.norm(way))
        leave = way / 3 + side + (0, 0, lift_m)
        leave[2] = max(leave[2], 0.01)
        arrive = -way / 3 + side + (0, 0, 0.6 * lift_m)
        arrive[2] = max(arrive[2], 0.01)
        return Swing(start, goal, leave, arrive, Tremor.sampled(self._rng, n / FRAME_RATE_HZ))

    def _add(self, part: str, motion: Motion, n: int) -> None:
        carried = {name: p for name, p in joined(part, self._links).items() if name != part}
        start_s, duration_s = self._frame / FRAME_RATE_HZ, n / FRAME_RATE_HZ
        self._moves.append(Move(part, start_s, duration_s, motion, carried))
        pose = motion.at(1.0)
        self._now[part] = pose
        for name, part_from_other in carried.items():
            self._now[name] = pose @ part_from_other
        self._frame += n


def _hull_points(mesh: Mesh) -> Array:
    """(N, 3) vertices of a part's convex hull, which decide how high it stands."""
    points: Array = mesh.vertices[ConvexHull(mesh.vertices).vertices].astype(np.float64)
    return points


def _sliding_frames(way_m: Array, n: int) -> int:
    length_m = float(np.linalg.norm(way_m))
    return int(np.clip(round(1.875 * length_m / 0.008), 12, n // 4 + 1)) if length_m else 0
