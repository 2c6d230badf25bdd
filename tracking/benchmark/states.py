"""Assembly states as a method reports them against the true ones."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

NEAR_FRAMES = 10
"""A switch is found if it is reported at most so many frames too early or too late; frames that
are further away from every true switch are called settled."""

_NAN = float("nan")


@dataclass(frozen=True)
class StateScore:
    """The assembly states of one sequence; not a number where nothing was reported.

    Attributes:
        accuracy: share of frames with the true state, 0 to 1.
        settled_accuracy: the same of settled frames alone: more than 10 away from a true switch.
        delay_frames: mean delay of the switches that were noticed; negative is early.
        n_switches: true changes of state.
        n_missed: those that were not noticed before the next one.
        n_found: those that were noticed within 10 frames, early or late.
        n_reported: changes of state that were reported, flicker included.
    """

    accuracy: float = _NAN
    settled_accuracy: float = _NAN
    delay_frames: float = _NAN
    n_switches: int = 0
    n_missed: int = 0
    n_found: int = 0
    n_reported: int = 0


NO_STATES = StateScore()


def judge_states(true: Sequence[str], reported: Sequence[str]) -> StateScore:
    """Compares the states of all frames.

    A true switch belongs to the first frame with the new state. It is noticed in the first frame
    from there on, and before the next switch, that reports the new state; or, where that frame
    reports it already, at the beginning of this report.

    Args:
        true: by frame; "" where unknown.
        reported: by frame; "" where the method says nothing, which counts as a wrong state.
    """
    if not any(reported) or not any(true):
        return NO_STATES
    switches = changes(true)
    right = np.array([t == r for t, r in zip(true, reported, strict=True)])
    known = np.array([t != "" for t in true])
    settled = known & ~_near(switches, len(true))
    spans = itertools.pairwise([*switches, len(true)])
    delays = [_delay(reported, f, end, true[f]) for f, end in spans]
    noticed = [delay for delay in delays if delay is not None]
    return StateScore(
        accuracy=float(right[known].mean()),
        settled_accuracy=float(right[settled].mean()) if settled.any() else _NAN,
        delay_frames=float(np.mean(noticed)) if noticed else _NAN,
        n_switches=len(switches),
        n_missed=len(delays) - len(noticed),
        n_found=sum(abs(delay) <= NEAR_FRAMES for delay in noticed),
        n_reported=len(changes(reported)),
    )


def changes(states: Sequence[str]) -> list[int]:
    """Frames whose state is another than the frame before had; both known."""
    return [
        f
        for f in range(1, len(states))
        if states[f] != states[f - 1] and states[f] and states[f - 1]
    ]


def _near(switches: Sequence[int], n_frames: int) -> npt.NDArray[np.bool_]:
    """(F,) whether a true switch is at most 10 frames away."""
    frames = np.arange(n_frames)
    near = np.zeros(n_frames, dtype=np.bool_)
    for switch in switches:
        near |= abs(frames - switch) <= NEAR_FRAMES
    return near


def _delay(reported: Sequence[str], switch: int, end: int, state: str) -> int | None:
    """Frames from a true switch to the report of its state; None if none comes until `end`."""
    if reported[switch] != state:
        return next((f - switch for f in range(switch, end) if reported[f] == state), None)
    first = switch
    while first > 0 and reported[first - 1] == state:
        first -= 1
    return first - switch
