"""Sequences in which one step is done wrongly, at the level of poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from tracks import Track

from snapfit.models.joint import angles
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.motion import minimum_jerk
from snapfit.tracking.assembly.contact import Contacts
from snapfit.tracking.assembly.estimate import MisassemblyKind
from snapfit.tracking.assembly.graph import AssemblyGraph
from snapfit.tracking.assembly.link_error import LinkMeasure

N_SETTLE, N_CARRY, N_REST = 14, 45, 60


@dataclass(frozen=True)
class WrongTrack:
    """A sequence that ends with a part at rest where it does not belong."""

    track: Track
    kind: MisassemblyKind
    part: str
    begin: int

    @property
    def rests_from(self) -> int:
        return self.begin + N_CARRY


class WrongTracks:
    """Makes wrong sequences from a right one."""

    def __init__(self, track: Track, seed: int) -> None:
        self.track = track
        self.graph = AssemblyGraph(track.asset)
        self.contacts = Contacts(track.asset.tracked_parts)
        self.rng = np.random.default_rng(seed)

    def all(self) -> Iterator[WrongTrack]:
        starts = [0, *self.track.switches[:-1]]
        for start in starts:
            state = self.track.states[start]
            for edge in self.graph.edges(state):
                yield from self._of_step(start + N_SETTLE, state, edge.deciding[0])

    def _of_step(self, begin: int, state: str, measure: LinkMeasure) -> Iterator[WrongTrack]:
        link = measure.link
        linked = self.graph.linked(state) | {self.graph.root}
        # What is brought is what does not belong to the module yet.
        mover, other = (link.child, link.parent)
        if mover in linked and other not in linked:
            mover, other = other, mover
        other_from_mover = measure.goal if mover == link.child else measure.goal.inverse()
        makers = [
            (MisassemblyKind.WRONG_PLACE, mover, self._elsewhere(begin, state, mover)),
            (
                MisassemblyKind.WRONG_WAY_ROUND,
                mover,
                self._flipped(begin, state, mover, self._at(begin, other) @ other_from_mover),
            ),
            (MisassemblyKind.WRONG_PART, *self._another(begin, state, measure)),
            (MisassemblyKind.WRONG_ORDER, *self._too_early(begin, state)),
        ]
        for kind, part, pose in makers:
            if part and pose is not None:
                yield self._carried(begin, part, pose, kind)

    def _at(self, frame: int, part: str) -> Pose:
        return self.track.poses[frame][part]

    def _carried(self, begin: int, part: str, goal: Pose, kind: MisassemblyKind) -> WrongTrack:
        """The right track up to a frame, from which a part is brought to a wrong pose."""
        poses = list(self.track.poses[: begin + 1])
        others = poses[-1]
        start = others[part]
        turn = (start.inverse() @ goal).log()[:3]
        for i in range(N_CARRY + N_REST):
            share = minimum_jerk((i + 1) / N_CARRY)
            way = start.translation + share * (goal.translation - start.translation)
            way[2] += 0.08 * np.sin(np.pi * share)
            rotation = start.rotation @ Pose.exp([*(share * turn), 0, 0, 0]).rotation
            here = Pose.from_rotation_translation(rotation, way)
            poses.append({**others, part: here})
        states = [*self.track.states[: begin + 1]]
        states += [states[-1]] * (N_CARRY + N_REST)
        return WrongTrack(replace(self.track, poses=poses, states=states), kind, part, begin)

    def _module(self, state: str) -> list[str]:
        component = self.graph.components(state)
        return [name for name, n in component.items() if n == component[self.graph.root]]

    def _gap_m(self, begin: int, state: str, part: str, pose: Pose) -> float:
        return min(
            self.contacts.gap_m(name, part, (self._at(begin, name).inverse() @ pose).matrix, 0.2)
            for name in self._module(state)
            if name != part
        )

    def _pushed(self, begin: int, state: str, part: str, pose: Pose, way: Array) -> Pose | None:
        """Moved along a direction from where it does not touch until it nearly touches."""
        away_m = 0.25
        while away_m > -0.05:
            here = Pose.from_translation(*(away_m * way)) @ pose
            gap_m = self._gap_m(begin, state, part, here)
            if gap_m < 0.0015:
                return here
            # It cannot touch before it has come nearer by the gap.
            away_m -= min(max(0.9 * gap_m, 0.0005), 0.05)
        return None

    def _elsewhere(self, begin: int, state: str, part: str) -> Pose | None:
        for _ in range(30):
            target = self.rng.choice(self._module(state))
            way = self.rng.standard_normal(3)
            way[2] = abs(way[2])
            way /= np.linalg.norm(way)
            rotation = Pose.exp([*self.rng.standard_normal(3), 0, 0, 0]).rotation
            center = self._at(begin, target).transform(self.contacts.center_m[target])
            origin = center - rotation @ self.contacts.center_m[part]
            pose = Pose.from_rotation_translation(rotation, origin)
            pushed = self._pushed(begin, state, part, pose, way)
            if pushed is not None and not self._fits(begin, state, part, pushed, 0.04):
                return pushed
        return None

    def _fits(self, begin: int, state: str, part: str, pose: Pose, far_m: float = 0.0) -> bool:
        """Whether a link is fulfilled after all, or a part is nearer to one than `far_m`."""
        poses = {**self.track.poses[begin], part: pose}
        for measure in (*self.graph.coming(state), *self.graph.later(state)):
            link = measure.link
            if part in (link.child, link.parent):
                fit = measure.fit((poses[link.parent].inverse() @ poses[link.child]).matrix)
                if fit.is_within_tolerance or fit.translation_m < far_m:
                    return True
        return False

    def _flipped(self, begin: int, state: str, part: str, goal: Pose) -> Pose | None:
        """Turned by half a turn about an axis that is none of its symmetry, about its middle."""
        symmetry = next(p.symmetry for p in self.track.asset.parts if p.name == part)
        center = self.contacts.center_m[part]
        for axis in self.rng.permutation(np.eye(3)):
            rotation = Pose.exp([*(np.pi * axis), 0, 0, 0]).rotation
            flip = Pose.from_rotation_translation(rotation, center - rotation @ center)
            same = symmetry.nearest(flip, Pose.identity())
            if angles(same.rotation[None])[0] < 0.5 or self._fits(begin, state, part, goal @ flip):
                continue
            if self._gap_m(begin, state, part, goal @ flip) < 0.003:
                return goal @ flip
        return None

    def _another(self, begin: int, state: str, measure: LinkMeasure) -> tuple[str, Pose | None]:
        """Another part in the place of the next one."""
        link, linked = measure.link, self.graph.linked(state) | {self.graph.root}
        free = [n for n in self.graph.tracked if n not in linked | {link.child, link.parent}]
        if not free or link.child in linked:
            return "", None
        part = str(self.rng.choice(free))
        place = self._at(begin, link.parent) @ measure.goal
        center = place.transform(self.contacts.center_m[link.child])
        pose = Pose.from_rotation_translation(
            place.rotation, center - place.rotation @ self.contacts.center_m[part]
        )
        if self._gap_m(begin, state, part, pose) > 0.003:
            return part, None
        return part, pose

    def _too_early(self, begin: int, state: str) -> tuple[str, Pose | None]:
        """A part in its own place, before its turn."""
        linked = self.graph.linked(state) | {self.graph.root}
        options = [
            measure
            for measure in self.graph.later(state)
            if measure.link.parent in linked and measure.link.child not in linked
        ]
        if not options:
            return "", None
        measure = options[self.rng.integers(len(options))]
        link = measure.link
        return link.child, self._at(begin, link.parent) @ measure.goal
