"""What a finder of first poses is."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Where a part may be.

    Attributes:
        part: its name.
        camera_from_body: the pose; of a symmetric part one that looks the same.
        score: how sure it is, 0 to 1; comparable among the hypotheses of one finder.
        is_refined: whether the tracker's own optimiser has refined it.
    """

    part: str
    camera_from_body: Pose
    score: float
    is_refined: bool = False


class Finder(Protocol):
    """Finds parts in a single frame; safe to use from one thread at a time."""

    names: tuple[str, ...]
    """Of the parts that it can find."""

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        """Look for parts.

        Args:
            frame: in which they are looked for.
            wanted: names of the parts.
            known: where other parts are in this frame, as far as that is known.

        Returns:
            Several a part perhaps, the surest first; none of a part that was not found.

        Raises:
            FrameError: the frame does not fit the camera.
            TrackingError: a part that this finder does not know, or it cannot work at all.
        """


@runtime_checkable
class CountsRejections(Protocol):
    """A finder that tells what it did not report."""

    rejected: Mapping[str, int]
    """Candidates that gave no hypothesis since it was made, by reason."""
