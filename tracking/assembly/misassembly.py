"""Parts that rest on the module as they should not: wrong place, way round, part, or order.

Only what has been moved, has come to rest against the module, and touches it, is looked at. Parts
that lie on the bench beside each other have not been moved; parts in the hand do not rest.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.pose import Array
from snapfit.tracking.assembly.contact import Contacts
from snapfit.tracking.assembly.estimate import Misassembly
from snapfit.tracking.assembly.graph import AssemblyGraph
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.assembly.relations import Relations, distances
from snapfit.tracking.assembly.wrongness import Situation, what_is_wrong

# Looked at again, should the first look have been taken before the hand was quite at rest.
_LOOK_AGAIN_FRAMES = 15


class MisassemblyWatch:
    """Watches all pairs of parts that are not joined.

    Args:
        asset: whose parts are watched.
        graph: of the asset.
        parameters: thresholds.
    """

    def __init__(self, asset: Asset, graph: AssemblyGraph, parameters: AssemblyParameters) -> None:
        self._graph = graph
        self._parameters = parameters
        self._contacts = Contacts(asset.tracked_parts)
        self._names = graph.tracked
        self._root = graph.root
        self._active: dict[str, tuple[Misassembly, int, Array]] = {}
        self._waiting: list[int] = []
        self._state: str | None = None
        names = self._names
        first, second = np.triu_indices(len(names), k=1)
        pairs = [(names[a], names[b]) for a, b in zip(first, second, strict=True)]
        radius, center = self._contacts.radius_m, self._contacts.center_m
        self._reach_m = np.array([radius[a] + radius[b] for a, b in pairs])
        self._reach_m += parameters.contact_m
        self._centers = np.array([[center[a], center[b]] for a, b in pairs]).reshape(-1, 2, 3)
        self._watched = np.zeros(len(pairs), dtype=np.bool_)

    def update(self, relations: Relations, state: str, frame: int) -> tuple[Misassembly, ...]:
        """Takes in a frame; returns what sits wrong now."""
        if state != self._state:
            self._enter(state)
        for part, (_, pair, place) in list(self._active.items()):
            if self._is_put_right(pair, place, relations):
                del self._active[part]
        self._waiting += [pair for pair in self._resting(relations) if pair not in self._waiting]
        if self._waiting:
            # One a frame: a look takes longer than all the rest.
            self._look(self._waiting.pop(0), relations, frame)
        return tuple(event for event, _, _ in self._active.values())

    def _enter(self, state: str) -> None:
        """Chooses the pairs to watch: a module and what is not part of it."""
        self._state = state
        component = self._graph.components(state)
        numbers = list(component.values())
        modules = {n for n in numbers if numbers.count(n) > 1} | {component.get(self._root, -1)}
        related = self._graph.related
        for i, (a, b) in enumerate(self._pairs()):
            apart = component[a] != component[b]
            is_module = component[a] in modules or component[b] in modules
            self._watched[i] = apart and (is_module or frozenset((a, b)) in related)
        for part, (event, _, _) in list(self._active.items()):
            if component[event.part] == component[event.parent]:
                del self._active[part]

    def _pairs(self) -> Iterable[tuple[str, str]]:
        for i, a in enumerate(self._names):
            for b in self._names[i + 1 :]:
                yield a, b

    def _resting(self, relations: Relations) -> list[int]:
        """Numbers of the watched pairs that have just come to rest near each other."""
        p = self._parameters
        still = relations.still_frames - p.wrong_frames
        due = (still == 0) | ((still > 0) & (still % _LOOK_AGAIN_FRAMES == 0))
        due &= self._watched & relations.has_moved & relations.is_seen
        if not due.any():
            return []
        rest, centers = relations.rest[due], self._centers[due]
        moved = (rest[:, :3, :3] @ centers[:, 1, :, None])[..., 0] + rest[:, :3, 3]
        near = np.linalg.norm(moved - centers[:, 0], axis=1) < self._reach_m[due]
        # Where it lay at first it lies on the bench again.
        way_m, turn_rad = distances(relations.start[due], rest)
        near &= (way_m > p.right_m) | (turn_rad > p.right_rad)
        return [int(pair) for pair in np.flatnonzero(due)[near]]

    def _look(self, pair: int, relations: Relations, frame: int) -> None:
        """Judges a pair at rest, and remembers what is wrong with it."""
        part, other = self._free_and_module(pair, relations)
        is_over = relations.still_frames[pair] < self._parameters.wrong_frames
        if part in self._active or is_over or not self._watched[pair] or self._state is None:
            return
        if relations.sure_frames[pair] < self._parameters.sure_share * relations.still_frames[pair]:
            return  # A part in doubt, or before which a hand is, is not told to be wrong.
        if not relations.has_been_moved(part):
            return  # It lies where it always lay: what was put beside it is in its own place.
        a, b = self._names[relations.first[pair]], self._names[relations.second[pair]]
        gap_m = self._contacts.gap_m(a, b, relations.rest[pair], self._parameters.contact_m)
        situation = Situation(self._graph, self._state, relations, self._contacts, self._parameters)
        verdict = what_is_wrong(situation, part, is_touching=np.isfinite(gap_m))
        if verdict is None:
            return
        since = frame - int(relations.still_frames[pair])
        kind, translation_m, rotation_rad = verdict
        event = Misassembly(part, other, kind, since, translation_m, rotation_rad)
        self._active[part] = event, pair, relations.rest[pair].copy()

    def _free_and_module(self, pair: int, relations: Relations) -> tuple[str, str]:
        """Of a pair, the part that does not belong to the module, and the other one."""
        a, b = self._names[relations.first[pair]], self._names[relations.second[pair]]
        component = self._graph.components(self._state or self._graph.start)
        sizes = [sum(n == component[name] for n in component.values()) for name in (a, b)]
        if component.get(self._root) == component[a] or sizes[0] > sizes[1]:
            return b, a
        if component.get(self._root) == component[b] or sizes[1] > sizes[0]:
            return a, b
        return (a, b) if self._graph.is_child_of(a, b) else (b, a)

    def _is_put_right(self, pair: int, place: Array, relations: Relations) -> bool:
        """Whether a part has left its wrong place."""
        if not relations.is_seen[pair]:
            return False
        here = relations.mean[pair : pair + 1]
        way_m, turn_rad = distances(place[None], here)
        p = self._parameters
        return bool(way_m[0] > p.right_m or turn_rad[0] > p.right_rad)
