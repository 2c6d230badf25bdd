"""Whether the tracker keeps up with its source.

A recording is played as a camera would deliver it (`Pacer`): a frame is exposed a frame's time
after the last one, and waits there until the tracker fetches it; where that takes longer than a
frame's time, all later ones are exposed later by whole frames, those that a camera would have lost.
So exposures that lie farther apart than the frame rate says tell how many.
"""

from __future__ import annotations

from typing import Any, NamedTuple


class FrameCount(NamedTuple):
    """How far the tracker was at one snapshot.

    Attributes:
        boot_id: of the worker's run.
        seq: frames tracked in it.
        captured_us: exposure of the last one.
    """

    boot_id: str
    seq: int
    captured_us: int

    @staticmethod
    def of(snapshot: dict[str, Any]) -> FrameCount:
        """At this JSON of a `PoseSnapshot`."""
        return FrameCount(snapshot["boot_id"], snapshot["seq"], snapshot["captured_at_us"])


def rate_hz(first: FrameCount, last: FrameCount) -> float:
    """Frames a second between two snapshots.

    Raises:
        ValueError: they belong to two runs of the worker, or no frame lies between.
    """
    _check(first, last)
    return (last.seq - first.seq) * 1e6 / (last.captured_us - first.captured_us)


def behind_ms(first: FrameCount, last: FrameCount, source_hz: float) -> float:
    """By how much the tracker fell behind between two snapshots.

    Raises:
        ValueError: as `rate_hz`.
    """
    _check(first, last)
    due_us = (last.seq - first.seq) * 1e6 / source_hz
    return max((last.captured_us - first.captured_us - due_us) / 1e3, 0.0)


def frames_lost(first: FrameCount, last: FrameCount, source_hz: float) -> int:
    """The whole frames that a camera would have delivered beyond those that were tracked.

    Raises:
        ValueError: as `rate_hz`.
    """
    # Stamps are whole microseconds, so that a frame lost exactly may look a little shorter.
    return int(behind_ms(first, last, source_hz) * source_hz / 1e3 + 1e-3)


def _check(first: FrameCount, last: FrameCount) -> None:
    if first.boot_id != last.boot_id:
        raise ValueError(f"the worker was started anew: {first.boot_id}, {last.boot_id}")
    if last.seq <= first.seq:
        raise ValueError(f"no frame was tracked between {first.seq} and {last.seq}")
