"""Names beside the parts of a picture: near their part, over nothing else, joined by a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array

Bytes = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]
Box = tuple[int, int, int, int]

_FONT, _SCALE, _THICKNESS = cv2.FONT_HERSHEY_DUPLEX, 0.85, 1
_TEXT_BGR, _LINE_BGR = (40, 40, 40), (90, 90, 90)
_PAD_PX, _BORDER_PX = 7, 6
_ANGLES, _STEP_PX = 36, 6
# A line that crosses another part or name costs as much as so many pixels of its length.
_CROSSING = 6.0
# As far from the outline as this share of the farthest point is far enough to be pointed at.
_DEEP = 0.75


@dataclass(frozen=True)
class Label:
    """A name.

    Attributes:
        name: of the part.
        box: left, top, right, bottom of the text with some space around, px.
        anchor: column and row on the part that the line leads to.
    """

    name: str
    box: Box
    anchor: tuple[int, int]


def place_labels(names: Sequence[str], part_id: Bytes, ink: Mask) -> list[Label]:
    """Finds a free place near its part for each name, the parts in the middle first.

    Args:
        names: of the parts, in the order of their ids.
        part_id: (H, W) 0 = nothing, i + 1 = the i-th part.
        ink: (H, W) what a name must not cover.

    Returns:
        Labels of the parts that are seen.
    """
    taken = ink.copy()
    labels = []
    middle = np.array(part_id.shape)[::-1] / 2
    seen = [i for i in range(len(names)) if (part_id == i + 1).any()]
    anchors = {i: _anchor(part_id == i + 1) for i in seen}
    for i in sorted(seen, key=lambda i: float(np.linalg.norm(anchors[i] - middle))):
        label = _placed(names[i], part_id, i + 1, anchors[i], taken)
        left, top, right, bottom = label.box
        taken[top:bottom, left:right] = True
        line = np.zeros(taken.shape, dtype=np.uint8)
        cv2.line(line, label.anchor, _nearest_in(label.box, label.anchor), 1, 3)
        taken |= line > 0
        labels.append(label)
    return labels


def draw_labels(image: Bytes, labels: Sequence[Label]) -> None:
    """Writes names and their lines into a picture (H, W, 3), in place."""
    for label in labels:
        end = _nearest_in(label.box, label.anchor)
        cv2.line(image, label.anchor, end, _LINE_BGR, 1, cv2.LINE_AA)
        cv2.circle(image, label.anchor, 4, (255, 255, 255), -1, cv2.LINE_AA)
        cv2.circle(image, label.anchor, 3, _LINE_BGR, -1, cv2.LINE_AA)
    for label in labels:
        left, _, _, bottom = label.box
        (_, _), baseline = cv2.getTextSize(label.name, _FONT, _SCALE, _THICKNESS)
        place = (left + _PAD_PX, bottom - _PAD_PX - baseline // 2)
        cv2.putText(image, label.name, place, _FONT, _SCALE, _TEXT_BGR, _THICKNESS, cv2.LINE_AA)


def _anchor(mask: Mask) -> Array:
    """(2,) column and row of a part's point that is far from its outline, in the middle of such."""
    inside = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 3)
    deep = np.argwhere(inside >= _DEEP * inside.max())[:, ::-1] - 1.0
    anchor: Array = deep[np.linalg.norm(deep - deep.mean(axis=0), axis=1).argmin()]
    return anchor


def _placed(name: str, part_id: Bytes, own_id: int, anchor: Array, taken: Mask) -> Label:
    """The nearest free place in any direction whose line crosses least."""
    (width, height), baseline = cv2.getTextSize(name, _FONT, _SCALE, _THICKNESS)
    half = np.array([width / 2 + _PAD_PX, (height + baseline) / 2 + _PAD_PX])
    sums = cv2.integral(taken.astype(np.uint8))
    size = np.array(part_id.shape)[::-1]
    best, best_cost = None, math.inf
    for k in range(_ANGLES):
        angle = 2 * math.pi * k / _ANGLES
        toward = np.array([math.cos(angle), math.sin(angle)])
        for reach in np.arange(_STEP_PX, float(size.max()), _STEP_PX):
            low = np.rint(anchor + reach * toward - half).astype(int)
            high = np.rint(anchor + reach * toward + half).astype(int)
            if (low < _BORDER_PX).any() or (high > size - _BORDER_PX).any():
                continue
            box = (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
            if _covered(sums, box) == 0:
                point = (round(float(anchor[0])), round(float(anchor[1])))
                cost = _cost(part_id, own_id, taken, point, box)
                if cost < best_cost:
                    best, best_cost = Label(name, box, point), cost
                break
    if best is None:
        left, top = (max(round(float(v)), _BORDER_PX) for v in anchor - half)
        box = (left, top, left + round(2 * half[0]), top + round(2 * half[1]))
        best = Label(name, box, (round(float(anchor[0])), round(float(anchor[1]))))
    return best


def _cost(part_id: Bytes, own_id: int, taken: Mask, anchor: tuple[int, int], box: Box) -> float:
    """Length of the line, px, and what it crosses beside its own part."""
    end = _nearest_in(box, anchor)
    n = max(abs(end[0] - anchor[0]), abs(end[1] - anchor[1]), 1)
    columns = np.rint(np.linspace(anchor[0], end[0], n + 1)).astype(int)
    rows = np.rint(np.linspace(anchor[1], end[1], n + 1)).astype(int)
    crossed = taken[rows, columns] & (part_id[rows, columns] != own_id)
    return math.hypot(end[0] - anchor[0], end[1] - anchor[1]) + _CROSSING * int(crossed.sum())


def _nearest_in(box: Box, point: tuple[int, int]) -> tuple[int, int]:
    """The point of a box that is nearest to another point."""
    left, top, right, bottom = box
    return min(max(point[0], left), right), min(max(point[1], top), bottom)


def _covered(sums: npt.NDArray[np.generic], box: Box) -> int:
    left, top, right, bottom = box
    covered = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return int(covered)
