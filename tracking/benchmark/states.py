"""How well a method knows the assembly state: accuracy, and delay of each switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StateScore:
    """The assembly states of one sequence; not a number where nothing was reported.

    Attributes:
        accuracy: share of frames with the true state, 0 to 1.
        delay_frames: mean delay of the switches that were noticed; negative is early.
        n_switches: true changes of state.
        n_missed: those that were not noticed before the next one.
    """

    accuracy: float
    delay_frames: float
    n_switches: int
    n_missed: int


NO_STATES = StateScore(float("nan"), float("nan"), 0, 0)


def judge_states(true: Sequence[str], reported: Sequence[str]) -> StateScore:
    """Compares the states of all frames.

    Args:
        true: by frame; "" where unknown.
        reported: by frame; "" where the method says nothing.
    """
    if not any(reported) or not any(true):
        return NO_STATES
    known = [(t, r) for t, r in zip(true, reported, strict=True) if t]
    switches = [
        f for f in range(1, len(true)) if true[f] != true[f - 1] and true[f] and true[f - 1]
    ]
    ends = [*switches[1:], len(true)]
    delays = [_delay(reported, f, end, true[f]) for f, end in zip(switches, ends, strict=True)]
    noticed = [delay for delay in delays if delay is not None]
    return StateScore(
        accuracy=sum(t == r for t, r in known) / len(known),
        delay_frames=float(np.mean(noticed)) if noticed else float("nan"),
        n_switches=len(switches),
        n_missed=len(delays) - len(noticed),
    )


def _delay(reported: Sequence[str], switch: int, end: int, state: str) -> int | None:
    """Frames from a true switch to the report of its state; None if none comes until `end`."""
    if reported[switch] != state:
        return next((f - switch for f in range(switch, end) if reported[f] == state), None)
    first = switch
    while first > 0 and reported[first - 1] == state:
        first -= 1
    return first - switch
