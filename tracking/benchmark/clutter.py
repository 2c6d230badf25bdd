"""How many parts a detector finds in cluttered images, and how much of what it says is right.

The images are a training set's (`snapfit dataset render --split train`), with foreign things, parts
of other assets, hands and other light in each; of another seed than the network was trained on.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset, find_asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import DatasetError
from snapfit.models.train_labels import TRAIN, Instance
from snapfit.models.train_reader import TrainSample, TrainSet
from snapfit.models.workbench.fan_out import RENDERING_NAME
from snapfit.models.workbench.train_set import TrainOrder
from snapfit.tracking.benchmark.rightness import LEAST_SEEN, PoseError
from snapfit.tracking.benchmark.roster import check_methods, entry
from snapfit.tracking.detection.detector import Detection, Detector
from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.method import FrameByFrameMethod

LEAST_OVERLAP, NEAR_M = 0.5, 0.1
"""Of boxes; and ADD(-S) that the GBOT paper counts as right."""

CRITERIA = ("box", "near", "right")
"""Box: overlaps by half; near: ADD(-S) under 10 cm; right: under 10 % of the diameter."""

_DEPTH_SCALE_M = 0.001

Progress = Callable[[str, float], None]


@dataclass
class Tally:
    """What a method said of the images of an asset, counted image by image.

    Attributes:
        asset, method: names.
        images: how many.
        parts: of these parts enough is seen, by part.
        said: detections, by part.
        found: of those parts that were found, by part and criterion.
        true: of those detections that are right, by part and criterion.
        times_ms: of each image.
    """

    asset: str
    method: str
    images: int = 0
    parts: Counter[str] = field(default_factory=Counter)
    said: Counter[str] = field(default_factory=Counter)
    found: Counter[tuple[str, str]] = field(default_factory=Counter)
    true: Counter[tuple[str, str]] = field(default_factory=Counter)
    times_ms: list[float] = field(default_factory=list)

    def recall(self, criterion: str) -> float:
        """Share of the parts that were found, 0 to 1."""
        found = sum(n for (_, each), n in self.found.items() if each == criterion)
        return found / max(sum(self.parts.values()), 1)

    def precision(self, criterion: str) -> float:
        """Share of the detections that are right, 0 to 1; not a number without any."""
        true = sum(n for (_, each), n in self.true.items() if each == criterion)
        said = sum(self.said.values())
        return true / said if said else float("nan")


class ImageJudge:
    """Compares detections with what is true in an image.

    Args:
        asset: whose parts they are. Parts of one mesh may stand for each other.
    """

    def __init__(self, asset: Asset) -> None:
        self._shapes = {part.name: part.mesh.digest for part in asset.tracked_parts}
        self._errors = {part.name: PoseError(part) for part in asset.tracked_parts}

    def add(self, tally: Tally, found: Sequence[Detection], instances: Sequence[Instance]) -> None:
        """Count an image.

        A part is found once: what is said of it again is wrong. What is right of a part of which
        little is seen is right, but need not be said.

        Args:
            tally: that is added to.
            found: the surest first.
            instances: all that can be seen of the asset.
        """
        tally.images += 1
        tally.said.update(each.part for each in found)
        wanted = [each for each in instances if each.visibility >= LEAST_SEEN]
        tally.parts.update(each.part for each in wanted)
        for criterion in CRITERIA:
            free = list(instances)
            for each in found:
                hit = next((other for other in free if self._agree(each, other, criterion)), None)
                if hit is None:
                    continue
                free.remove(hit)
                tally.true[each.part, criterion] += 1
                if hit.visibility >= LEAST_SEEN:
                    tally.found[hit.part, criterion] += 1

    def _agree(self, said: Detection, true: Instance, criterion: str) -> bool:
        if self._shapes[said.part] != self._shapes[true.part]:
            return False
        if criterion == "box":
            return overlap(said.box_px, true.box_inside) >= LEAST_OVERLAP
        error = self._errors[true.part]
        if criterion == "right":
            return error.is_right(said.camera_from_body, true.camera_from_body)
        return error.add_m(said.camera_from_body, true.camera_from_body) < NEAR_M


def overlap(box_px: npt.NDArray[np.floating], true: Sequence[int]) -> float:
    """Intersection over union of left, top, right, bottom and of x, y, width, height."""
    left, top, width, height = true
    common_x = min(box_px[2], left + width) - max(box_px[0], left)
    common_y = min(box_px[3], top + height) - max(box_px[1], top)
    common = max(float(common_x), 0.0) * max(float(common_y), 0.0)
    area = float((box_px[2] - box_px[0]) * (box_px[3] - box_px[1]))
    return common / max(area + width * height - common, 1e-9)


def check_can_detect(methods: Sequence[str]) -> None:
    """Makes sure that these methods say what is in a single image.

    Raises:
        TrackingError: there is no such method, or it needs more than an image.
    """
    check_methods(methods)
    for method in methods:
        _single_image(method)


def judge_images(
    folder: Path, asset_name: str, method: str, progress: Progress | None = None
) -> Tally:
    """Has a method look at all images of an asset's set.

    Args:
        folder: the set's folder of this asset.
        asset_name: its name.
        method: checked by `check_can_detect`.
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        DatasetError: no finished set there, an image is missing, or depth is needed and missing.
        DetectorError: the asset has no network, or one that does not fit.
    """
    asset, samples, chosen = find_asset(asset_name), images_of(folder), _single_image(method)
    parameters = DetectorParameters(range=RangeParameters() if chosen.uses_depth else None)
    tally, judge, detector = Tally(asset.name, method), ImageJudge(asset), None
    for number, sample in enumerate(samples):
        color = sample.labels.camera
        camera = RgbdCamera(color, color if chosen.uses_depth else None, _DEPTH_SCALE_M)
        if detector is None:
            network = asset.directory / chosen.variant
            detector = Detector(network, asset.tracked_parts, camera, parameters)
        # Each image has intrinsics of its own; the size, to which the network's input is fitted,
        # is that of the set.
        detector.camera = camera
        depth = _depth(sample) if chosen.uses_depth else None
        said = detector.detect(Frame(sample.path.stem, 0, sample.image(), depth))
        judge.add(tally, said.found, sample.labels.instances)
        tally.times_ms.append(said.duration_ms)
        if progress is not None:
            progress(f"{asset.name} {method}", (number + 1) / len(samples))
    return tally


def images_of(folder: Path) -> list[TrainSample]:
    """The images of a set that no network was trained on.

    Of a set with the seed that training images have by default only those for validation.

    Raises:
        DatasetError: no finished set there, or none of its images is left.
    """
    data = TrainSet(folder)
    path = folder / TRAIN / RENDERING_NAME
    try:
        seed = json.loads(path.read_text(encoding="utf-8"))["seed"]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise DatasetError(path, f"cannot be read ({error}): render the set again") from error
    samples = list(data) if seed != TrainOrder.seed else data.selected(validation=True)
    if not samples:
        problem = f"all its images are for training: render others, --seed {seed + 1}"
        raise DatasetError(path, problem)
    return samples


def _single_image(method: str) -> FrameByFrameMethod:
    chosen = entry(method)
    if not isinstance(chosen, FrameByFrameMethod):
        raise TrackingError(f"{method} does not look at single images; yolov8pose does")
    return chosen


def _depth(sample: TrainSample) -> npt.NDArray[np.uint16]:
    path = sample.path.parents[1] / "depth" / f"{sample.path.stem}.png"
    depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.is_file() else None
    if depth is None:
        problem = "is missing: render the set with --depth, or leave out methods that use it"
        raise DatasetError(path, problem)
    counts: npt.NDArray[np.uint16] = np.asarray(depth, dtype=np.uint16)
    return counts
