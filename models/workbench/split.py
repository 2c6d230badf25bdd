"""The test split in one table: which assets, how many frames each, under which conditions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

FRAME_RATE_HZ = 30.0
TEST_SEED = 20

TEST_FRAMES = {
    "nano-chuck": 900,
    "hobby-corner-clamp": 400,
    "geared-caliper": 500,
    "hand-screw-clamp": 750,
    "liftpod": 900,
}


class Condition(StrEnum):
    """What makes a scene hard to track."""

    NORMAL = "normal"
    DYNAMIC = "dynamic"
    BLUR = "blur"
    HAND = "hand"
    ALL = "all"


@dataclass(frozen=True)
class Effects:
    """What a condition switches on.

    Attributes:
        moving_light: a point light goes around, with shadows, in place of the room's lamps.
        exposure: share of the frame interval during which the shutter is open; 0 is an instant.
        hand: a hand and forearm move the parts.
    """

    moving_light: bool = False
    exposure: float = 0.0
    hand: bool = False


_EXPOSURE = 0.65

EFFECTS = {
    Condition.NORMAL: Effects(),
    Condition.DYNAMIC: Effects(moving_light=True),
    Condition.BLUR: Effects(exposure=_EXPOSURE),
    Condition.HAND: Effects(hand=True),
    Condition.ALL: Effects(moving_light=True, exposure=_EXPOSURE, hand=True),
}
