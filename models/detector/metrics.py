"""How well a network finds parts in whole images: precision, recall, and keypoints' errors."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass

import numpy as np
import torch
from torch import Tensor

from snapfit.models.detector.boxes import iou, scale
from snapfit.models.detector.network import PoseNetwork, RawOutput
from snapfit.models.detector.targets import Targets
from snapfit.models.detector.trainer import as_input

LEAST_SCORE, LEAST_OVERLAP = 0.25, 0.5


@dataclass(frozen=True)
class Validation:
    """How well a network does; the best anchor of each class counts in each image.

    Attributes:
        images, parts: in how many images, with how many parts that are to be found.
        recall: share of the parts' classes that are found, with a score of 0.25 and an overlap of
            half with one that is there.
        precision: share of what scores 0.25 that is right, parts that are hardly seen left out.
        overlap: median, of those that are found.
        keypoint_error: median distance of the keypoints in the image, in sizes of the part.
        keypoint_error_px: the same in pixels of the input.
    """

    images: int
    parts: int
    recall: float
    precision: float
    overlap: float
    keypoint_error: float
    keypoint_error_px: float

    def to_json(self) -> dict[str, float]:
        """As it stands in `detector.json`."""
        values = {name: float(value) for name, value in asdict(self).items()}
        return {name: round(value, 5) for name, value in values.items() if math.isfinite(value)}


@torch.no_grad()
def validated(
    network: PoseNetwork, batches: Iterable[tuple[Tensor, Targets]], device: torch.device
) -> Validation:
    """Runs a network over images as they are."""
    network.eval()
    tally = _Tally()
    for images, targets in batches:
        tally.add(network(as_input(images, device)), targets.to(device))
    return tally.result()


class _Tally:
    def __init__(self) -> None:
        self.images = self.parts = self.wanted = self.found = self.said = 0
        self.overlaps: list[float] = []
        self.errors: list[float] = []
        self.errors_px: list[float] = []

    def add(self, raw: RawOutput, targets: Targets) -> None:
        """Takes in what was said of a batch."""
        scores, best = raw.classes.float().sigmoid().max(dim=1)
        boxes = raw.boxes()
        self.images += len(scores)
        self.parts += int(targets.is_wanted.sum())
        for image in range(len(scores)):
            for number in range(scores.shape[1]):
                anchor = best[image, number]
                is_said = bool(scores[image, number] >= LEAST_SCORE)
                self._judge(targets, image, number, boxes[image, anchor], is_said)
                if self._last is not None:
                    where = torch.tensor([image]), anchor[None].cpu()
                    points = raw.points_at(where[0].to(boxes.device), anchor[None])[0]
                    self._measure(points, targets, image, self._last)

    def _judge(self, targets: Targets, image: int, number: int, box: Tensor, is_said: bool) -> None:
        """Counts one class in one image; `_last` is the part it found."""
        self._last: int | None = None
        there = torch.nonzero(targets.classes[image] == number)[:, 0]
        is_wanted = targets.is_wanted[image, there]
        overlaps = iou(targets.boxes[image, there], box)
        self.wanted += bool(is_wanted.any())
        if not is_said:
            return
        if len(there) and float(overlaps.max()) >= LEAST_OVERLAP:
            part = int(overlaps.argmax())
            if not is_wanted[part]:
                return
            self.found += 1
            self.overlaps.append(float(overlaps[part]))
            self._last = int(there[part])
        self.said += 1

    def _measure(self, points: Tensor, targets: Targets, image: int, part: int) -> None:
        true = targets.keypoints[image, part]
        distances = (points - true[:, :2]).norm(dim=-1)[true[:, 2] > 0]
        self.errors_px += distances.tolist()
        self.errors += (distances / scale(targets.boxes[image, part])).tolist()

    def result(self) -> Validation:
        """The figures."""
        return Validation(
            images=self.images,
            parts=self.parts,
            recall=self.found / max(self.wanted, 1),
            precision=self.found / max(self.said, 1),
            overlap=_median(self.overlaps),
            keypoint_error=_median(self.errors),
            keypoint_error_px=_median(self.errors_px),
        )


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
