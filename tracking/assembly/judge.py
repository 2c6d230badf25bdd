"""Which assembly state holds: forward when links come into being, back when they come apart."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.pose import Array, Pose
from snapfit.tracking.assembly.confidence import state_confidence
from snapfit.tracking.assembly.estimate import (
    AssemblyEstimate,
    Misassembly,
    PartObservation,
    Probe,
    StateChange,
)
from snapfit.tracking.assembly.evidence import LinkEvidence, Spread
from snapfit.tracking.assembly.graph import AssemblyGraph, Edge
from snapfit.tracking.assembly.link_error import LinkMeasure
from snapfit.tracking.assembly.misassembly import MisassemblyWatch
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.assembly.relations import Relations, distances
from snapfit.tracking.assembly.undoing import Undoing
from snapfit.tracking.assembly.unseen_turns import UnseenTurns
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.result import Status

_DEFAULT = AssemblyParameters()


class StateJudge:
    """Follows the assembly graph through the frames of one sequence.

    Args:
        asset: with an assembly graph.
        parameters: thresholds; `GBOT_PAPER` for the paper's own behaviour.

    Raises:
        TrackingError: the asset has no assembly graph.
    """

    def __init__(self, asset: Asset, parameters: AssemblyParameters = _DEFAULT) -> None:
        self.graph = AssemblyGraph(asset)
        self.parameters = parameters
        self.relations = Relations(self.graph.tracked, parameters)
        self._turns = UnseenTurns({part.name: part.symmetry for part in asset.parts})
        self._linked: frozenset[str] = frozenset()
        self._watch = MisassemblyWatch(asset, self.graph, parameters)
        self._taken: list[str] = []
        self._hold_frames = 0
        self._at_override: Array | None = None
        self._enter(self.graph.start)

    @property
    def state(self) -> str:
        """Name of the current state."""
        return self._state

    def set_state(self, state: str) -> None:
        """An operator says which state holds.

        For `hold_frames` the evidence of that moment counts for nothing: before then only what
        changes anew leads to another state.

        Raises:
            TrackingError: no such state.
        """
        if state not in self.graph.states:
            names = ", ".join(self.graph.states)
            raise TrackingError(f"there is no assembly state {state!r}; there are: {names}")
        self._hold_frames = self.parameters.hold_frames
        self._at_override = self.relations.mean.copy()
        self._enter(state)

    def update(
        self,
        observations: Iterable[PartObservation],
        frame: int,
        probe: Probe | None = None,
    ) -> AssemblyEstimate:
        """Takes in a frame and says which state holds.

        Args:
            observations: of the tracked parts, in any order.
            frame: number of the frame, for the reports of what sits wrong.
            probe: asks the image about a part in its place; None if nobody can.
        """
        seen = {each.part: each for each in observations}
        if self.parameters.thresholds_alone:
            return self._estimate(seen, self._take(self._by_thresholds(seen)))
        trusted = {name: pose for name, each in seen.items() if (pose := self._trusted(each))}
        # What is linked is held by its module, also where little of it is seen.
        sure = [name for name, each in seen.items() if each.is_sure or name in self._linked]
        self.relations.update(self._turns.taken_out(trusted, self._linked), sure)
        self._undoing.update(seen)
        for evidence in self._evidence.values():
            for each in evidence:
                self._gather(each, seen, trusted, probe)
        change = self._take(self._forward() or self._backward())
        self._hold_frames = max(self._hold_frames - 1, 0)
        wrong = self._watch.update(self.relations, self._state, frame)
        return self._estimate(seen, change, wrong)

    def _trusted(self, observation: PartObservation) -> Pose | None:
        """The pose of a part that is seen well, or carried by a link to one that is."""
        is_seen = observation.status is Status.TRACKED
        is_seen &= observation.confidence >= self.parameters.least_confidence
        return observation.camera_from_body if is_seen or self._is_carried(observation) else None

    def _is_carried(self, observation: PartObservation) -> bool:
        return observation.status is Status.INFERRED and observation.part in self._linked

    def _gather(
        self,
        evidence: LinkEvidence,
        seen: Mapping[str, PartObservation],
        trusted: Mapping[str, Pose],
        probe: Probe | None,
    ) -> None:
        """Measures a link, or looks for a hidden part in its place."""
        parent, child = evidence.measure.link.parent, evidence.measure.link.child
        if parent in trusted and child in trusted:
            mean = self.relations.mean_of(parent, child)
            spread = Spread()
            if not evidence.is_far(mean):
                spread = _spread(seen[parent], seen[child], mean)
            evidence.see(mean, self.relations.still_of(parent, child), spread)
            if seen[child].is_sure or seen[child].status is not Status.TRACKED:
                evidence.forget_support()
                return
        else:
            evidence.miss()
        if probe is not None:
            evidence.ask(*_looked_for(evidence.measure, trusted, probe))

    def _forward(self) -> StateChange | None:
        """The step, or steps, that the evidence shows to be done."""
        for edge, evidence in self._evidence.items():
            if not all(each.is_ready for each in evidence) or self._is_held(edge):
                continue
            assumed = self._assumed.get(edge, ())
            if all(each.is_unknown for each in assumed) and all(
                each.is_measured for each in evidence if assumed
            ):
                fits = tuple(e.fit for e in evidence if e.fit is not None and e.is_measured)
                steps = tuple(step.name for step in edge.steps)
                return StateChange(self._state, edge.to_state, True, steps, fits)
        return None

    def _is_held(self, edge: Edge) -> bool:
        """Whether an operator's word stands against an edge whose parts have not moved since."""
        if self._hold_frames == 0 or self._at_override is None:
            return False
        for measure in edge.deciding:
            pair, _ = self.relations.pair(measure.link.parent, measure.link.child)
            here = slice(pair, pair + 1)
            way_m, turn_rad = distances(self._at_override[here], self.relations.mean[here])
            if way_m[0] > self.parameters.moved_m or turn_rad[0] > self.parameters.moved_rad:
                return False
        return True

    def _backward(self) -> StateChange | None:
        """To the latest state that lacks a link which no longer holds."""
        broken = self._undoing.contradicted(is_held=self._hold_frames > 0)
        if broken is None:
            return None
        to_state = self.graph.without_link(self._state, broken.link, self._taken)
        if to_state is None:
            return None
        path = [step.name for step in self.graph.path_to(self._state, self._taken)]
        kept = len(self.graph.path_to(to_state, self._taken))
        return StateChange(self._state, to_state, False, tuple(path[kept:]), (broken,))

    def _by_thresholds(self, seen: Mapping[str, PartObservation]) -> StateChange | None:
        """The GBOT paper's switch: at once when all deciding links are within tolerance."""
        poses = {name: each.camera_from_body for name, each in seen.items()}
        for edge in self.graph.edges(self._state):
            fits = []
            for measure in edge.deciding:
                parent, child = poses.get(measure.link.parent), poses.get(measure.link.child)
                if parent is not None and child is not None:
                    fits.append(measure.fit_at_zero((parent.inverse() @ child).matrix))
            if len(fits) == len(edge.deciding) and all(each.is_within_tolerance for each in fits):
                steps = tuple(step.name for step in edge.steps)
                return StateChange(self._state, edge.to_state, True, steps, tuple(fits))
        return None

    def _take(self, change: StateChange | None) -> StateChange | None:
        if change is None:
            return None
        if change.is_forward:
            self._taken += change.steps
        self._hold_frames = 0
        self._enter(change.to_state)
        return change

    def _enter(self, state: str) -> None:
        """Begins to gather evidence against a new state."""
        p, graph = self.parameters, self.graph
        self._state = state
        changed = self._linked ^ graph.linked(state)
        self.relations.begin_anew(self._turns.forget(changed))
        self._linked = graph.linked(state)
        path = graph.path_to(state, self._taken)
        self._finished = tuple(step.name for step in path)
        self._taken = list(self._finished)
        self._next = tuple(step.name for step in graph.next_steps(state))
        self._undoing = Undoing(graph.held(state), p)
        self._evidence = {
            edge: tuple(LinkEvidence(measure, p) for measure in edge.deciding)
            for edge in graph.edges(state)
        }
        self._assumed: dict[Edge, tuple[LinkEvidence, ...]] = {}
        for edge, leap in graph.leaps(state):
            self._assumed[leap] = self._evidence[edge]
            self._evidence[leap] = tuple(LinkEvidence(measure, p) for measure in leap.deciding)

    def _estimate(
        self,
        seen: Mapping[str, PartObservation],
        change: StateChange | None,
        wrong: tuple[Misassembly, ...] = (),
    ) -> AssemblyEstimate:
        ways = (min((e.progress for e in each), default=0.0) for each in self._evidence.values())
        leaving = max(self._undoing.progress, *ways, 0.0)
        confidence = state_confidence(self.graph.held(self._state), seen, leaving)
        return AssemblyEstimate(self._state, confidence, change, self._finished, self._next, wrong)


def _looked_for(
    measure: LinkMeasure, trusted: Mapping[str, Pose], probe: Probe
) -> tuple[float, Array | None]:
    """Confidence in the image, and `parent_from_child`, of a part looked for in its place."""
    parent, child = measure.link.parent, measure.link.child
    if parent in trusted:
        support, found = probe(child, trusted[parent] @ measure.goal)
        return support, None if found is None else (trusted[parent].inverse() @ found).matrix
    if child in trusted:
        support, found = probe(parent, trusted[child] @ measure.goal.inverse())
        return support, None if found is None else (found.inverse() @ trusted[child]).matrix
    return math.nan, None


def _spread(parent: PartObservation, child: PartObservation, parent_from_child: Array) -> Spread:
    """How uncertain `parent_from_child` is; the parent's rotation moves a child that is far."""
    parent_m, parent_rad = _deviations(parent)
    child_m, child_rad = _deviations(child)
    arm = float(np.linalg.norm(parent_from_child[:3, 3])) * parent_rad
    return Spread(math.hypot(parent_m, child_m, arm), math.hypot(parent_rad, child_rad))


def _deviations(observation: PartObservation) -> tuple[float, float]:
    if observation.covariance is None:
        return 0.0, 0.0
    turn, way = np.diag(observation.covariance).reshape(2, 3).mean(axis=1)
    return math.sqrt(max(float(way), 0.0)), math.sqrt(max(float(turn), 0.0))
