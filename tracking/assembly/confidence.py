"""How sure the judge is of the state."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from snapfit.tracking.assembly.estimate import PartObservation
from snapfit.tracking.assembly.link_error import LinkMeasure

# A tracker's confidence of a part that is barely tracked must not drown the other links.
_LEAST = 0.05


def state_confidence(
    held: Sequence[LinkMeasure],
    observations: Mapping[str, PartObservation],
    leaving: float,
) -> float:
    """Confidence of a state, 0 to 1.

    The geometric mean over its links of the root of the child's own confidence and of how well its
    own pose agrees with its link, exp(-d^2 / 2) with d the distance in tolerances; less up to a
    half as evidence for another state grows. A state without links has only the latter.

    Args:
        held: links of the state.
        observations: by part.
        leaving: how much of what is needed to leave the state is there, 0 to 1.
    """
    logs = [math.log(_of_link(each, observations)) for each in held]
    mean = math.exp(sum(logs) / len(logs)) if logs else 1.0
    return mean * (1 - leaving / 2)


def _of_link(measure: LinkMeasure, observations: Mapping[str, PartObservation]) -> float:
    child = observations.get(measure.link.child)
    if child is None or child.camera_from_body is None:
        return 0.5
    own = math.sqrt(min(max(child.confidence, _LEAST), 1.0))
    free = child.free_camera_from_body
    if free is None:
        return own
    apart = free.translation - child.camera_from_body.translation
    distance = math.sqrt(float(apart @ apart)) / measure.link.translation_tolerance_m
    return own * max(math.exp(-(distance**2) / 2), _LEAST)
