"""Follows the assembly graph while parts are tracked (GBOT, section 3.3, and past it).

The judge says which state holds; its links become the optimiser's. Each linked part is also
tried out without its link, in turns, so that a part that comes off is noticed.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from snapfit.models.asset import Asset
from snapfit.models.pose import Array, Pose
from snapfit.tracking.assembly.estimate import UNSEEN, AssemblyEstimate, PartObservation, Sighting
from snapfit.tracking.assembly.judge import StateJudge
from snapfit.tracking.assembly.parameters import GBOT_PAPER, AssemblyParameters
from snapfit.tracking.assembly.unclear import unclear_places
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.linking import Linker
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.result import PartEstimate, Status

_SAME_M, _SAME_RAD = 0.006, math.radians(8)
_CONVINCING = 0.5
_BETTER, _VISIBLE = 1.15, 0.2
_FIT_M, _AS_GOOD = 0.012, 0.95
_HIDDEN, _FEW_POINTS = 0.1, 20
_BETTER_BY = 0.1
_AGREEMENT_RATE, _SURE = 0.1, 0.75


@dataclass(frozen=True)
class GraphParameters:
    """How the assembly graph is used.

    Attributes:
        judge: when a state is left.
        is_told: the state is told from outside (`set_state`), nothing is judged.
        is_rigid: links are rigid even where the manifest has a joint.
    """

    judge: AssemblyParameters = field(default_factory=AssemblyParameters)
    is_told: bool = False
    is_rigid: bool = False


PAPER_GRAPH = GraphParameters(judge=GBOT_PAPER, is_rigid=True)


class GraphFollower:
    """The assembly graph of one tracker.

    Args:
        asset: with an assembly graph.
        names: of the tracked parts, in the optimiser's order.
        optimiser: whose bodies are linked.
        parameters: how.

    Raises:
        TrackingError: the asset has no assembly graph, or a part is not the asset's.
    """

    def __init__(
        self,
        asset: Asset,
        names: Sequence[str],
        optimiser: Optimiser,
        parameters: GraphParameters,
    ) -> None:
        parts = {part.name: part for part in asset.parts}
        if unknown := [name for name in names if name not in parts]:
            raise TrackingError(f"asset {asset.name!r} has no part {unknown[0]!r}")
        self._names, self._optimiser, self._parameters = tuple(names), optimiser, parameters
        self._judge = StateJudge(asset, parameters.judge)
        self._linker = Linker(
            [parts[name] for name in names], optimiser, is_rigid=parameters.is_rigid
        )
        self._unclear = unclear_places(asset.tracked_parts, asset.states)
        self._shadows: dict[str, Pose] = {}
        self._turn = 0
        self._frame = 0
        self._is_seen = dict.fromkeys(self._names, True)
        self._rivals: dict[str, float] = {}
        self._held_q: dict[int, Array] = {}
        # Running mean of each part's agreement with the image, and the best that it has been.
        self._agreement = dict.fromkeys(self._names, 0.0)
        self._best = dict.fromkeys(self._names, 0.0)

    @property
    def state(self) -> str:
        """Name of the assembly state that is believed."""
        return self._judge.state

    def parent_of(self, part: str) -> str | None:
        """Name of the part that carries a part; None where it is free."""
        return self._linker.parent_of(part)

    def set_state(self, state: str) -> tuple[str, ...]:
        """Somebody who knows says which state holds; returns the parts whose pose jumped.

        Raises:
            TrackingError: no such state.
        """
        if state == self._judge.state:
            return ()
        self._judge.set_state(state)
        return self._link()

    def follow(
        self, estimates: Sequence[PartEstimate], absent: Collection[str] = ()
    ) -> tuple[AssemblyEstimate, tuple[str, ...]]:
        """Judge a frame, and link or unlink parts; returns the parts whose pose jumped, too.

        Args:
            estimates: of all parts, in order.
            absent: linked parts whose places are seen without them.
        """
        if self._parameters.is_told:
            return self._told(), ()
        self._frame += 1
        # Of the refinement: what is tried out below leaves other Hessians behind.
        inverses = self._optimiser.inverse_hessians()
        self._is_seen = {each.part: self._surely_seen(each) for each in estimates}
        self._hold_hidden(estimates)
        poses = {each.part: each.camera_from_body for each in estimates}
        free: Mapping[str, Pose] = {}
        if not self._parameters.judge.thresholds_alone:  # the paper tries nothing out
            free = self._try_without_link(estimates)
            poses |= self._fitting(poses)
        observations = [
            PartObservation(
                each.part,
                each.status,
                each.confidence,
                poses[each.part],
                None if each.camera_from_body is None else inverses[body],
                each.visibility,
                free.get(each.part),
                self._is_seen[each.part],
                each.part in absent,
            )
            for body, each in enumerate(estimates)
        ]
        assembly = self._judge.update(observations, self._frame, self._probe)
        return assembly, () if assembly.changed is None else self._link()

    def _hold_hidden(self, estimates: Sequence[PartEstimate]) -> None:
        """A linked part that nobody sees stays where it was on its joint.

        What little is seen of it, the hand before it more often than not, would move it along.
        What it carries may tell where it is.
        """
        structures, moved = self._optimiser.structures, False
        for body, each in enumerate(estimates):
            if not structures.arrays.n_dof[body]:
                continue
            q = structures.arrays.q[body]
            hidden = each.status is Status.INFERRED and each.visibility < _VISIBLE
            if body in self._held_q and hidden and not self._carries_seen(body):
                q[:] = self._held_q[body]
                moved = True
            else:
                self._held_q[body] = q.copy()
        for root in {structures.root(body) for body in self._held_q} if moved else ():
            self._optimiser.move(root, self._optimiser.pose(root))

    def _carries_seen(self, body: int) -> bool:
        """Whether a part that another one carries is seen well."""
        parent_of = self._optimiser.structures.parent
        for other, name in enumerate(self._names):
            above = parent_of(other) if self._is_seen[name] else None
            while above is not None and above != body:
                above = parent_of(above)
            if above is not None:
                return True
        return False

    def _told(self) -> AssemblyEstimate:
        """The assembly as somebody said that it is."""
        graph, state = self._judge.graph, self._judge.state
        finished = tuple(step.name for step in graph.path_to(state))
        coming = tuple(step.name for step in graph.next_steps(state))
        return AssemblyEstimate(state, 1.0, None, finished, coming)

    def _link(self) -> tuple[str, ...]:
        state = self._judge.graph.states[self._judge.state]
        jumped = self._linker.apply(state.links, self._is_seen)
        # What has come off goes where it was found to be by itself.
        freed = {name: pose for name, pose in self._shadows.items() if not self._is_linked(name)}
        for name, pose in freed.items():
            self._optimiser.move(self._names.index(name), pose)
        self._shadows.clear()
        self._held_q.clear()
        return (*jumped, *freed)

    def _fitting(self, poses: Mapping[str, Pose | None]) -> Mapping[str, Pose]:
        """Another pose of a part in its place, where the image agrees with it as well.

        A thread that sticks in a jaw can turn about itself unseen: its pose is one of many, and
        the one that its link wants is as good as any. One part is tried in a frame.
        """
        for edge in self._judge.graph.edges(self._judge.state):
            for measure in edge.deciding:
                link = measure.link
                parent, child = poses.get(link.parent), poses.get(link.child)
                if parent is None or child is None or not self._is_seen[link.child]:
                    continue
                relative = (parent.inverse() @ child).matrix
                if measure.is_far(relative, _FIT_M):
                    continue
                fit = measure.fit(relative)
                if fit.translation_m > _FIT_M or fit.rotation_rad < _SAME_RAD / 2:
                    continue
                wanted = parent @ measure.joint.parent_from_child(fit.q)
                wanted = wanted @ fit.child_symmetry.inverse()
                body = self._names.index(link.child)
                tried = self._optimiser.attempt(body, wanted)
                near = tried.camera_from_body.angle_to(wanted) < _SAME_RAD
                as_good = tried.likelihood > _AS_GOOD * self._optimiser.likelihoods[body]
                return {link.child: tried.camera_from_body} if near and as_good else {}
        return {}

    def _probe(self, part: str, pose: Pose) -> Sighting:
        """What the image says of a part at a place."""
        if part not in self._names or part in self._unclear or pose.translation[2] <= 0:
            return UNSEEN
        tried = self._optimiser.attempt(self._names.index(part), pose, in_front=True)
        evidence = tried.evidence
        if not tried.solved or evidence.visibility < _HIDDEN or evidence.points < _FEW_POINTS:
            return UNSEEN
        # Likelihoods of poses that show different sides of a part cannot be compared.
        is_better = evidence.confidence > self._rivals.get(part, 0.0) + _BETTER_BY
        return Sighting(evidence.confidence if is_better else 0.0, tried.camera_from_body)

    def _surely_seen(self, estimate: PartEstimate) -> bool:
        """Whether a part is tracked, and agrees with the image about as well as it has done."""
        part, is_tracked = estimate.part, estimate.status is Status.TRACKED
        self._rivals[part] = estimate.confidence if is_tracked else 0.0
        if not is_tracked:
            return False
        mean = self._agreement[part]
        mean += _AGREEMENT_RATE * (estimate.confidence - mean)
        self._agreement[part] = mean
        self._best[part] = best = max(self._best[part], mean)
        return estimate.confidence >= _SURE * best

    def _try_without_link(self, estimates: Sequence[PartEstimate]) -> Mapping[str, Pose]:
        """Where linked parts would be by themselves; one of a structure is tried in each frame.

        A part that has come off is tried again and again; then those in doubt; else each in turn.
        What is found for a part that carries others is told as the opposite motion of these.
        """
        linked = {
            each.part: each.camera_from_body
            for each in estimates
            if each.camera_from_body is not None and self._is_linked(each.part)
        }
        doubtful = [
            each.part
            for each in estimates
            if each.part in linked and each.status is Status.INFERRED and each.visibility > _VISIBLE
        ]
        waiting = [name for name in self._shadows if name in linked] or doubtful or list(linked)
        if not waiting:
            return {}
        self._turn += 1
        name = waiting[self._turn % len(waiting)]
        free = self._tried(name, linked[name])
        told = {name: free} if self._linker.parent_of(name) else {}
        if name in self._shadows:
            opposite = linked[name] @ free.inverse()
            for child, pose in linked.items():
                if self._linker.parent_of(child) == name:
                    told[child] = opposite @ pose
        return told

    def _tried(self, name: str, pose: Pose) -> Pose:
        """Where a part would be by itself; its pose where that is no better."""
        body = self._names.index(name)
        tried = self._optimiser.attempt(body, self._shadows.pop(name, pose))
        found = tried.camera_from_body
        differs = found.distance_to(pose) > _SAME_M or found.angle_to(pose) > _SAME_RAD
        better = tried.likelihood > _BETTER * max(self._optimiser.likelihoods[body], 1.0)
        if differs and better and tried.solved and tried.evidence.confidence > _CONVINCING:
            self._shadows[name] = found
            return found
        return pose

    def _is_linked(self, name: str) -> bool:
        return len(self._optimiser.structures.members(self._names.index(name))) > 1
