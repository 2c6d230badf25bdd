"""How fast the parts of a script go, measured from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.pose import Pose
from snapfit.models.workbench.script import Script
from snapfit.models.workbench.split import FRAME_RATE_HZ

_STILL_MM, _STILL_DEG = 0.05, 0.05


@dataclass(frozen=True)
class Speed:
    """Steps from frame to frame of the part in hand, over the frames in which it moves.

    Attributes:
        median_mm: of its origin.
        peak_mm: the longest.
        median_deg: of its turn.
        peak_deg: the largest.
        moving_share: share of the frames in which something moves.
    """

    median_mm: float
    peak_mm: float
    median_deg: float
    peak_deg: float
    moving_share: float


def moving_part(script: Script, frame: int) -> str | None:
    """The part in hand between this frame and the one before; None while all rest."""
    middle_s = (frame - 0.5) / FRAME_RATE_HZ
    for move in script.moves:
        if move.start_s < middle_s < move.end_s:
            return move.part
    return None


def speed_of(script: Script, n_frames: int, parts: frozenset[str]) -> Speed:
    """Measures a script of so many frames, while one of the parts is in hand."""
    steps: list[tuple[float, float]] = []
    before = script.poses_at(0.0)
    for frame in range(1, n_frames):
        now = script.poses_at(frame / FRAME_RATE_HZ)
        part = moving_part(script, frame)
        if part in parts and part is not None:
            steps.append(_step(before[part], now[part]))
        before = now
    return summarised([step for step in steps if _moves(step)], n_frames)


def summarised(steps: Sequence[tuple[float, float]], n_frames: int) -> Speed:
    """Figures of steps (mm, deg), each of a frame in which something moves."""
    if not steps:
        return Speed(0.0, 0.0, 0.0, 0.0, 0.0)
    mm, deg = np.array(steps).T
    return Speed(
        float(np.median(mm)),
        float(mm.max()),
        float(np.median(deg)),
        float(deg.max()),
        len(steps) / max(n_frames - 1, 1),
    )


def _step(before: Pose, now: Pose) -> tuple[float, float]:
    return before.distance_to(now) * 1000, float(np.degrees(before.angle_to(now)))


def _moves(step: tuple[float, float]) -> bool:
    return step[0] > _STILL_MM or step[1] > _STILL_DEG
