"""What the assembly judge is told of a part, and what it says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from snapfit.models.pose import Array, Pose
from snapfit.tracking.assembly.link_error import LinkFit
from snapfit.tracking.result import Status


class Sighting(NamedTuple):
    """What the image says of a part that is looked for at a place.

    Attributes:
        confidence: how well it agrees with a part that stands there, 0 to 1; 0 where another pose
            of the part agrees about as well; not a number where it could not be seen anyway.
        camera_from_body: the pose near the place that agrees best; None without one.
    """

    confidence: float
    camera_from_body: Pose | None = None


UNSEEN = Sighting(math.nan)

Probe = Callable[[str, Pose], Sighting]
"""`probe(part, camera_from_body)`: looks for a part at a place."""


@dataclass(frozen=True, eq=False)
class PartObservation:
    """A part in a frame.

    Attributes:
        part: its name.
        status: where the pose comes from.
        confidence: 0 to 1.
        camera_from_body: its pose, with its link where it has one; None when there is none.
        covariance: (6, 6) of the right perturbation in the body frame, rotation (rad) then
            translation (m); None where unknown.
        visibility: share of it that is seen, 0 to 1.
        free_camera_from_body: where a linked part's own evidence would have it; None where it has
            none, or is not linked.
        is_sure: whether it is seen by itself, and agrees with the image about as well as it does
            when all is well: a part that was found again at a place where it is not seldom does.
        is_absent: whether the place where its link has it is seen, and it is not there.
    """

    part: str
    status: Status
    confidence: float
    camera_from_body: Pose | None
    covariance: Array | None = None
    visibility: float = 1.0
    free_camera_from_body: Pose | None = None
    is_sure: bool = True
    is_absent: bool = False


class MisassemblyKind(StrEnum):
    """What is wrong with a part."""

    WRONG_PLACE = "wrong_place"
    WRONG_WAY_ROUND = "wrong_way_round"
    WRONG_PART = "wrong_part"
    WRONG_ORDER = "wrong_order"


@dataclass(frozen=True, eq=False)
class Misassembly:
    """A part that rests on another one as it should not.

    Attributes:
        part: that is wrong.
        parent: that it touches or, where it has its place, that it is linked to.
        kind: in what way.
        since_frame: number of the frame in which it came to rest there.
        translation_m: how far its origin is from its own place; not a number if it has none now.
        rotation_rad: how far it is turned against its own place; likewise.
    """

    part: str
    parent: str
    kind: MisassemblyKind
    since_frame: int
    translation_m: float
    rotation_rad: float


@dataclass(frozen=True, eq=False)
class StateChange:
    """A switch of the assembly state.

    Attributes:
        from_state: name of the state that is left.
        to_state: name of the state that holds from now on.
        is_forward: whether steps were finished; else they were undone, or an operator decided.
        steps: names of the steps finished, or undone, in the order of the assembly.
        fits: of the links that decided, measured; for a forward switch they name the symmetric
            pose of parent and child that agrees with the link.
    """

    from_state: str
    to_state: str
    is_forward: bool
    steps: tuple[str, ...]
    fits: tuple[LinkFit, ...] = ()


@dataclass(frozen=True, eq=False)
class AssemblyEstimate:
    """The assembly in a frame.

    Attributes:
        state: name of the state.
        confidence: 0 to 1, see `confidence.py`.
        changed: the switch made in this frame; None if the state stayed.
        finished_steps: names, in order.
        next_steps: names of those that can be taken now.
        misassemblies: what sits wrong.
    """

    state: str
    confidence: float
    changed: StateChange | None
    finished_steps: tuple[str, ...]
    next_steps: tuple[str, ...]
    misassemblies: tuple[Misassembly, ...] = ()
