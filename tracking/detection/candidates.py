"""From the network's output to candidates: decoding, and non-maximum suppression."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.tracking.detection.parameters import CandidateParameters

Floats = npt.NDArray[np.float32]
AnyFloats = npt.NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Candidates:
    """N anchors that may show a part, the best first.

    Attributes:
        classes: (N,) int64 number of the class.
        scores: (N,) 0 to 1.
        boxes: (N, 4) left, top, right, bottom, px of the input.
        keypoints: (N, K, 3) x, y (px of the input) and presence, 0 to 1.
        n_not_finite: anchors left out because a number of theirs is none.
    """

    classes: npt.NDArray[np.int64]
    scores: Floats
    boxes: Floats
    keypoints: Floats
    n_not_finite: int = 0

    def __len__(self) -> int:
        return len(self.classes)

    def chosen(self, which: npt.NDArray[np.int64]) -> Candidates:
        """Some of them, in the order given."""
        return Candidates(
            self.classes[which],
            self.scores[which],
            self.boxes[which],
            self.keypoints[which],
            self.n_not_finite,
        )


def decoded(output: Floats, n_classes: int, parameters: CandidateParameters) -> Candidates:
    """The anchors that score enough, the best first.

    Args:
        output: (4 + C + 3 K, A) as the public layout has it.
        n_classes: C.
        parameters: how much is enough.
    """
    scores = output[4 : 4 + n_classes]
    best = scores.max(axis=0)
    # Not a number compares as false: such anchors are let through here and dropped below.
    likely = np.flatnonzero(~(best < parameters.least_score))
    columns = output[:, likely].T
    is_finite = np.isfinite(columns).all(axis=1)
    likely, columns = likely[is_finite], columns[is_finite]
    order = np.argsort(-best[likely], kind="stable")[: parameters.most_candidates]
    columns = columns[order]
    center, half = columns[:, :2], columns[:, 2:4] / 2
    n_keypoints = (len(output) - 4 - n_classes) // 3
    return Candidates(
        classes=columns[:, 4 : 4 + n_classes].argmax(axis=1),
        scores=best[likely[order]],
        boxes=np.concatenate([center - half, center + half], axis=1),
        keypoints=columns[:, 4 + n_classes :].reshape(-1, n_keypoints, 3),
        n_not_finite=int((~is_finite).sum()),
    )


def suppressed(candidates: Candidates, parameters: CandidateParameters) -> Candidates:
    """One candidate for each part: of those of a class that overlap, the best one.

    Args:
        candidates: the best first.
        parameters: how much two of them overlap that are one, and how many parts there may be.
    """
    kept: list[int] = []
    count = np.zeros(int(candidates.classes.max(initial=0)) + 1, dtype=np.int64)
    is_free = np.ones(len(candidates), dtype=np.bool_)
    for i in range(len(candidates)):
        number = candidates.classes[i]
        if not is_free[i] or count[number] >= parameters.most_instances:
            continue
        kept.append(i)
        count[number] += 1
        same = (candidates.classes == number) & (
            overlaps(candidates.boxes[i], candidates.boxes) > parameters.same_overlap
        )
        is_free &= ~same
    return candidates.chosen(np.array(kept, dtype=np.int64))


def overlaps(box: AnyFloats, boxes: AnyFloats) -> AnyFloats:
    """(N,) intersection over union of a box (4,) with boxes (N, 4)."""
    near = np.maximum(box[:2], boxes[:, :2])
    far = np.minimum(box[2:], boxes[:, 2:])
    common = np.maximum(far - near, 0).prod(axis=1)
    areas = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    total = float((box[2:] - box[:2]).prod()) + areas - common
    result: AnyFloats = common / np.maximum(total, 1e-9)
    return result
