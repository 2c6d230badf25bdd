"""Which parts a method loses, and from which frame to which."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.scores import PAPER_THRESHOLD_M, STRICT_SHARE

LOST_FRAMES = 15
"""A part that is not right in the last frames of a sequence was lost if they are so many."""


@dataclass(frozen=True)
class Loss:
    """A stretch of frames in which a part was lost.

    Attributes:
        part: its name.
        first, last: frames, counted from 0.
        comes_back: whether its pose is right again after them.
    """

    part: str
    first: int
    last: int
    comes_back: bool

    @property
    def text(self) -> str:
        """For tables: `jaw 120-180`, or `jaw 120-` if it never comes back."""
        return f"{self.part} {self.first}-{self.last if self.comes_back else ''}"


def losses(run: Run) -> list[Loss]:
    """The losses of a run, by part.

    A pose is right if its ADD(-S) is below 10 % of the part's diameter. A stretch of frames with
    no right pose is a loss if in one of them ADD(-S) is over 10 cm or there is no estimate, or if
    it lasts until the end of the sequence, for 15 frames at least.
    """
    right = run.is_within(STRICT_SHARE)
    far = ~(run.error("add_m") < PAPER_THRESHOLD_M)
    found = []
    for i, part in enumerate(run.parts):
        for is_right, group in itertools.groupby(range(len(right)), key=right[:, i].__getitem__):
            if is_right:
                continue
            frames = np.array(list(group))
            comes_back = int(frames[-1]) < len(right) - 1
            if far[frames, i].any() or (not comes_back and len(frames) >= LOST_FRAMES):
                found.append(Loss(part, int(frames[0]), int(frames[-1]), comes_back))
    return found
