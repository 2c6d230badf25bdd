"""The multi-state assembly graph: states, the steps between them, and the links that decide.

States form a directed acyclic graph (GBOT paper, section 3.3, where it is a chain): sequences may
branch, and a state may be reached by several ways.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from snapfit.models.asset import Asset
from snapfit.models.manifest import Link, State, Step
from snapfit.models.symmetry import NO_SYMMETRY
from snapfit.tracking.assembly.link_error import LinkMeasure
from snapfit.tracking.errors import TrackingError

_SAME_M, _SAME_RAD = 1e-6, 1e-6


@dataclass(frozen=True, eq=False)
class Edge:
    """A way from one state to a later one.

    Attributes:
        steps: taken on the way, in order; more than one where what comes between cannot be seen.
        from_state: where it begins.
        to_state: where it ends.
        new_links: links that come into being, or whose child gets another place.
        deciding: how to measure those by which the last step is judged.
    """

    steps: tuple[Step, ...]
    from_state: str
    to_state: str
    new_links: tuple[Link, ...]
    deciding: tuple[LinkMeasure, ...]


class AssemblyGraph:
    """An asset's assembly graph, ready to be asked.

    Attributes:
        start: name of the first state.
        states: by name, in the order of the manifest.
        tracked: names of the tracked parts.
        related: pairs of parts that some state links.
        root: name of the part that carries all others in the last state; empty without links.

    Raises:
        TrackingError: the asset has no states.
    """

    def __init__(self, asset: Asset) -> None:
        if not asset.states:
            raise TrackingError(
                f"asset {asset.name!r} has no assembly graph: add [[state]] and [[step]] to "
                f"{asset.directory / 'asset.toml'}, or choose a method that tracks single parts"
            )
        self.start = asset.states[0].name
        self.states: dict[str, State] = {state.name: state for state in asset.states}
        self.tracked = tuple(part.name for part in asset.tracked_parts)
        self._steps = asset.steps
        self._symmetries = {part.name: part.symmetry for part in asset.parts}
        self._edges = {name: tuple(self._find_edges(name)) for name in self.states}
        self._leaps = {name: tuple(self._find_leaps(name)) for name in self.states}
        self._held = {
            name: tuple(
                LinkMeasure(link, self._symmetries[link.child])
                for link in self._tracked_links(state.links)
            )
            for name, state in self.states.items()
        }
        self._coming = {name: tuple(self._find_coming(name)) for name in self.states}
        links = [link for state in asset.states for link in state.links]
        self.related = frozenset(frozenset((link.parent, link.child)) for link in links)
        self._parents = frozenset((link.child, link.parent) for link in links)
        children = {link.child for link in asset.states[-1].links}
        roots = [link.parent for link in asset.states[-1].links if link.parent not in children]
        self.root = roots[0] if roots else ""
        self._later = {name: tuple(self._find_later(name)) for name in self.states}

    def edges(self, state: str) -> tuple[Edge, ...]:
        """The ways on from a state whose end can be recognised."""
        return self._edges[state]

    def leaps(self, state: str) -> tuple[tuple[Edge, Edge], ...]:
        """The ways over two steps, for a part that nobody sees being put in its place.

        Returns:
            pairs (way on from the state, way on beyond it, with the steps of both).
        """
        return self._leaps[state]

    def held(self, state: str) -> tuple[LinkMeasure, ...]:
        """How to measure the links that a state has between tracked parts."""
        return self._held[state]

    def coming(self, state: str) -> tuple[LinkMeasure, ...]:
        """How to measure all links that the next steps make, deciding or not."""
        return self._coming[state]

    def is_child_of(self, child: str, parent: str) -> bool:
        """Whether a part stands on another in some state."""
        return (child, parent) in self._parents

    def later(self, state: str) -> tuple[LinkMeasure, ...]:
        """How to measure links that only come into being after the next states."""
        return self._later[state]

    def successors(self, state: str) -> tuple[str, ...]:
        """Names of the states one step on."""
        return tuple(step.to_state for step in self._steps if step.from_state == state)

    def predecessors(self, state: str) -> tuple[str, ...]:
        """Names of the states one step back."""
        return tuple(step.from_state for step in self._steps if step.to_state == state)

    def next_steps(self, state: str) -> tuple[Step, ...]:
        """Steps that can be taken in a state."""
        return tuple(step for step in self._steps if step.from_state == state)

    def path_to(self, state: str, taken: Iterable[str] = ()) -> tuple[Step, ...]:
        """Steps from the start to a state; of several ways that with the most steps taken.

        Args:
            state: where the way ends.
            taken: names of the steps that are known to have been taken.
        """
        wanted = frozenset(taken)
        ways = [
            (*self.path_to(step.from_state, wanted), step)
            for step in self._steps
            if step.to_state == state
        ]
        return max(ways, key=lambda way: sum(s.name in wanted for s in way), default=())

    def without_link(self, state: str, link: Link, taken: Iterable[str] = ()) -> str | None:
        """The latest state on the way to a state that lacks a link; None if all have it."""
        path = self.path_to(state, taken)
        for step in reversed(path):
            if not has_link(self.states[step.from_state].links, link):
                return step.from_state
        return None

    def new_links(self, from_state: str, to_state: str) -> tuple[Link, ...]:
        """Links of a state that another one has not, or has at another place."""
        old = self.states[from_state].links
        return tuple(each for each in self.states[to_state].links if not has_link(old, each))

    def linked(self, state: str) -> frozenset[str]:
        """Names of the parts that a state links to others."""
        return frozenset(n for each in self.states[state].links for n in (each.parent, each.child))

    def components(self, state: str) -> dict[str, int]:
        """Which tracked parts a state joins: those with the same number."""
        number = {name: i for i, name in enumerate(self._symmetries)}
        for link in self.states[state].links:
            old, new = number[link.child], number[link.parent]
            number = {name: new if value == old else value for name, value in number.items()}
        return {name: number[name] for name in self.tracked}

    def _find_edges(self, state: str, before: tuple[Step, ...] = ()) -> Iterable[Edge]:
        first = before[0].from_state if before else state
        for step in self.next_steps(state):
            new = self.new_links(state, step.to_state)
            decides = self._tracked_links([link for link in new if link.decides_switch])
            # A step of which nothing can be seen shows when the next one does.
            if not decides and not (decides := self._tracked_links(new)):
                yield from self._find_edges(step.to_state, (*before, step))
                continue
            measures = tuple(self._measure(link, first) for link in decides)
            everything = self.new_links(first, step.to_state)
            yield Edge((*before, step), first, step.to_state, everything, measures)

    def _find_leaps(self, state: str) -> Iterable[tuple[Edge, Edge]]:
        for edge in self._edges[state]:
            for beyond in self._edges[edge.to_state]:
                deciding = tuple(self._measure(each.link, state) for each in beyond.deciding)
                everything = self.new_links(state, beyond.to_state)
                steps = edge.steps + beyond.steps
                yield edge, Edge(steps, state, beyond.to_state, everything, deciding)

    def _find_coming(self, state: str) -> Iterable[LinkMeasure]:
        new: list[Link] = []
        for edge in self._edges[state]:
            new += [link for link in edge.new_links if not has_link(new, link)]
        for link in self._tracked_links(new):
            yield self._measure(link, state)

    def _find_later(self, state: str) -> Iterable[LinkMeasure]:
        """Links beyond the next states, each once."""
        known = list(self.states[state].links)
        waiting = [edge.to_state for edge in self._edges[state]]
        for name in waiting:
            known += self.states[name].links
        while waiting:
            name = waiting.pop(0)
            waiting += self.successors(name)
            for link in self._tracked_links(self.states[name].links):
                if not has_link(known, link):
                    known.append(link)
                    yield self._measure(link, state)

    def _measure(self, link: Link, state: str) -> LinkMeasure:
        """A part that a state already links has a pose that no symmetry may change."""
        fixed = self.linked(state)
        child, parent = (
            NO_SYMMETRY if name in fixed else self._symmetries[name]
            for name in (link.child, link.parent)
        )
        return LinkMeasure(link, child, parent)

    def _tracked_links(self, links: Sequence[Link]) -> tuple[Link, ...]:
        tracked = self.tracked
        return tuple(each for each in links if each.parent in tracked and each.child in tracked)


def has_link(links: Iterable[Link], wanted: Link) -> bool:
    """Whether a link is among others: the same parts at the same place."""
    for link in links:
        if (link.parent, link.child) == (wanted.parent, wanted.child):
            apart = link.parent_from_child, wanted.parent_from_child
            return (
                apart[0].distance_to(apart[1]) < _SAME_M and apart[0].angle_to(apart[1]) < _SAME_RAD
            )
    return False
