"""Follows the assembly graph while parts are tracked (GBOT, section 3.3, and past it).

The judge says which state holds; its links become the optimiser's. Each linked part is also
tried out without its link, in turns, so that a part that comes off is noticed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from snapfit.models.asset import Asset
from snapfit.models.pose import Pose
from snapfit.tracking.assembly.estimate import AssemblyEstimate, PartObservation
from snapfit.tracking.assembly.judge import StateJudge
from snapfit.tracking.assembly.parameters import GBOT_PAPER, AssemblyParameters
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.linking import Linker
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.result import PartEstimate, Status

_SAME_M, _SAME_RAD = 0.006, math.radians(8)
_CONVINCING = 0.5
_BETTER = 1.15


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
        self._shadows: dict[str, Pose] = {}
        self._turn = 0
        self._frame = 0
        self._is_seen = dict.fromkeys(self._names, True)

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

    def follow(self, estimates: Sequence[PartEstimate]) -> tuple[AssemblyEstimate, tuple[str, ...]]:
        """Judge a frame, and link or unlink parts; returns the parts whose pose jumped, too."""
        self._frame += 1
        self._is_seen = {each.part: each.status is Status.TRACKED for each in estimates}
        free = {} if self._parameters.judge.thresholds_alone else self._try_without_link(estimates)
        observations = [
            PartObservation(
                each.part,
                each.status,
                each.confidence,
                each.camera_from_body,
                each.covariance,
                each.visibility,
                free.get(each.part),
            )
            for each in estimates
        ]
        assembly = self._judge.update(observations, self._frame, self._probe)
        return assembly, () if assembly.changed is None else self._link()

    def _link(self) -> tuple[str, ...]:
        self._shadows.clear()
        state = self._judge.graph.states[self._judge.state]
        return self._linker.apply(state.links, self._is_seen)

    def _probe(self, part: str, pose: Pose) -> float:
        """How well the image agrees with a part at a place; NaN where it cannot be seen there."""
        tried = self._optimiser.attempt(self._names.index(part), pose)
        if not tried.solved or tried.evidence.visibility < 0.1 or tried.evidence.points < 20:
            return math.nan
        found = tried.camera_from_body
        near = found.distance_to(pose) < 2 * _SAME_M and found.angle_to(pose) < 2 * _SAME_RAD
        return tried.evidence.confidence if near else 0.0

    def _try_without_link(self, estimates: Sequence[PartEstimate]) -> Mapping[str, Pose]:
        """Where one linked part, another in each frame, would be by itself."""
        linked = [
            (each.part, each.camera_from_body)
            for each in estimates
            if self._linker.parent_of(each.part) and each.camera_from_body is not None
        ]
        if not linked:
            return {}
        self._turn += 1
        name, pose = linked[self._turn % len(linked)]
        body = self._names.index(name)
        tried = self._optimiser.attempt(body, self._shadows.get(name, pose))
        found = tried.camera_from_body
        differs = found.distance_to(pose) > _SAME_M or found.angle_to(pose) > _SAME_RAD
        better = tried.likelihood > _BETTER * max(self._optimiser.likelihoods[body], 1.0)
        convincing = tried.solved and tried.evidence.confidence > _CONVINCING
        self._shadows.pop(name, None)
        if differs and better and convincing:
            self._shadows[name] = found
            return {name: found}
        return {name: pose}
