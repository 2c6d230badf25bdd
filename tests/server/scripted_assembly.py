"""The assembly of the scripted pipeline: three states in a row, and who says which one holds."""

from __future__ import annotations

import math

from snapfit.models.manifest import Annotation, Ghost, Link, State, Step
from snapfit.models.pose import Pose
from snapfit.tracking.assembly.estimate import AssemblyEstimate, Misassembly, MisassemblyKind
from snapfit.tracking.errors import TrackingError

BASE_FROM_JAW = Pose.from_quaternion([0, 0, math.sin(0.25), math.cos(0.25)], [0.01, 0.02, 0.03])
BASE_FROM_BOLT = Pose.from_translation(-0.05, 0, 0.01)
_JAW = Link(parent="base", child="jaw", parent_from_child=BASE_FROM_JAW)
_BOLT = Link(parent="base", child="bolt", parent_from_child=BASE_FROM_BOLT)
STATES = (
    State(name="free", title="All parts free"),
    State(name="jaw-mounted", title="Jaw on the base", link=(_JAW,)),
    State(name="assembled", title="Done", link=(_JAW, _BOLT)),
)
STEPS = (
    Step(
        name="mount-jaw",
        title="Mount the jaw",
        text="Put the jaw on the base.",
        from_state="free",
        to_state="jaw-mounted",
        parts=("base", "jaw"),
        ghost=Ghost(part="jaw", parent="base", parent_from_part=BASE_FROM_JAW),
        annotation=(Annotation(part="jaw", anchor_m=(0.1, 0.2, 0.3), text="This side up"),),
        media=("https://example.com/jaw.mp4",),
        expected_duration_s=8,
    ),
    Step(
        name="screw-bolt",
        title="Screw in the bolt",
        text="Turn it clockwise.",
        from_state="jaw-mounted",
        to_state="assembled",
        parts=("base", "bolt"),
        ghost=Ghost(part="bolt", parent="cap", parent_from_part=BASE_FROM_BOLT),
    ),
)
NAMES = tuple(state.name for state in STATES)
WRONG = Misassembly("pin", "base", MisassemblyKind.WRONG_PLACE, 1, 0.012, math.nan)
CONFIDENCE = 0.9


class ScriptedJudge:
    """Says what it was told, or, where it assembles by itself, another state every few frames."""

    def __init__(self, frames_a_state: int = 0) -> None:
        self._frames_a_state = frames_a_state
        self._frame = 0
        self._place = 0

    def set_state(self, state: str) -> None:
        if state not in NAMES:
            raise TrackingError(f"there is no assembly state {state!r}")
        self._place = NAMES.index(state)

    def judge(self) -> AssemblyEstimate:
        """Free, jaw mounted, assembled, then back again; wrong where the jaw is mounted."""
        self._frame += 1
        if self._frames_a_state:
            turn = (0, 1, 2, 1)
            self._place = turn[self._frame // self._frames_a_state % len(turn)]
        names = tuple(step.name for step in STEPS)
        wrong = (WRONG,) if self._frames_a_state and self._place == 1 else ()
        return AssemblyEstimate(
            NAMES[self._place],
            CONFIDENCE,
            None,
            names[: self._place],
            names[self._place : self._place + 1],
            wrong,
        )
