"""Finds the parts of an asset in one image: network, non-maximum suppression, PnP."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.detector.card import CARD_NAME, ONNX_NAME, read_card
from snapfit.models.errors import DetectorError
from snapfit.models.pose import Array, Pose
from snapfit.tracking.detection.box_placement import placed_by_box
from snapfit.tracking.detection.candidates import Candidates, decoded, suppressed
from snapfit.tracking.detection.letterbox import Letterbox, free_input_size
from snapfit.tracking.detection.measured_range import ranged
from snapfit.tracking.detection.onnx_model import OnnxModel
from snapfit.tracking.detection.parameters import DetectorParameters
from snapfit.tracking.detection.pnp import PnpPose, Rejection, pose_from_keypoints
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.frame import Frame, check_frame


@dataclass(frozen=True, eq=False)
class Detection:
    """One part that was found.

    Attributes:
        part: its name.
        score: of its class, 0 to 1.
        confidence: the score times the share of its keypoints that agree, 0 to 1.
        box_px: (4,) left, top, right, bottom in the image.
        keypoints_px: (K, 2) where the network sees them.
        presence: (K,) 0 to 1, how surely each is in the image.
        is_inlier: (K,) those that agree with the pose.
        error_px: root mean square of their distances.
        camera_from_body: the pose; of a symmetric part one that looks the same.
        is_ranged: whether measured depth fixed its distance.
    """

    part: str
    score: float
    confidence: float
    box_px: Array
    keypoints_px: Array
    presence: npt.NDArray[np.float32]
    is_inlier: npt.NDArray[np.bool_]
    error_px: float
    camera_from_body: Pose
    is_ranged: bool = False


@dataclass(frozen=True, eq=False)
class Detections:
    """What was found in an image.

    Attributes:
        frame: its name.
        found: parts, the surest first; of a part perhaps several.
        rejected: how many candidates gave no pose, by reason.
        duration_ms: all of it.
    """

    frame: str
    found: tuple[Detection, ...]
    rejected: Mapping[str, int] = field(default_factory=dict)
    duration_ms: float = 0.0

    def best(self) -> dict[str, Detection]:
        """The surest of each part."""
        return {each.part: each for each in reversed(self.found)}


class Detector:
    """Finds parts with a network; a `Finder`, safe to use from one thread at a time.

    Attributes:
        names: of the parts that it can find.
        camera: whose images it is for.
        input_size: width and height of the network's input, px.
        provider: of ONNX Runtime that runs the network.
        rejected: candidates that gave no pose, by reason; counted since it was made.
    """

    def __init__(
        self,
        folder: Path,
        parts: Sequence[Part],
        camera: RgbdCamera,
        parameters: DetectorParameters | None = None,
    ) -> None:
        """Loads a network and tries it once.

        Args:
            folder: that holds `detector.onnx` and `detector.json`.
            parts: that are to be found; the network's other classes are passed over.
            camera: whose images it is for.
            parameters: of all steps.

        Raises:
            DetectorError: a file is missing, damaged, or does not fit the other.
            TrackingError: the network knows none of the parts, or ONNX Runtime cannot be used.
        """
        self._parameters = parameters or DetectorParameters()
        card = read_card(folder / CARD_NAME)
        self._parts = {part.name: part for part in parts}
        self._classes = card.classes
        self.names = tuple(each.part for each in card.classes if each.part in self._parts)
        if not self.names:
            known = ", ".join(each.part for each in card.classes)
            raise TrackingError(f"{folder / ONNX_NAME} finds {known}: none of them is to be found")
        settings = self._parameters
        self._model = OnnxModel(
            folder / ONNX_NAME, card, providers=settings.providers, threads=settings.threads
        )
        self.provider = self._model.provider
        self.rejected: Counter[str] = Counter()
        self.camera = camera
        image = camera.color.width, camera.color.height
        meant = card.input_width_px, card.input_height_px
        self.input_size = self._model.input_size or free_input_size(image, meant)
        self._letterbox = Letterbox(*image, *self.input_size)
        width, height = self.input_size
        self._model.run(np.zeros((1, 3, height, width), dtype=np.float32))

    def detect(self, frame: Frame) -> Detections:
        """Finds what can be found.

        Raises:
            FrameError: the frame does not fit the camera.
            DetectorError: the network does not run.
        """
        begin = time.perf_counter()
        check_frame(frame, self.camera)
        output = self._model.run(self._letterbox.apply(frame.color))
        candidates = decoded(output, len(self._classes), self._parameters.candidates)
        kept = suppressed(candidates, self._parameters.candidates)
        rejected: Counter[str] = Counter()
        if kept.n_not_finite:
            rejected[Rejection.NOT_FINITE] = kept.n_not_finite
        found = []
        for place in range(len(kept)):
            each = self._posed(kept, place, frame)
            if isinstance(each, Rejection):
                rejected[each] += 1
            elif each is not None:
                found.append(each)
        found.sort(key=lambda each: -each.confidence)
        self.rejected.update(rejected)
        duration_ms = 1e3 * (time.perf_counter() - begin)
        return Detections(frame.name, tuple(found), dict(rejected), duration_ms)

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        """As `Finder.find`: where the wanted parts may be, the surest first.

        Raises:
            FrameError: the frame does not fit the camera.
            TrackingError: a part that this detector does not know, or the network does not run.
        """
        del known  # it looks at single images
        unknown = sorted(set(wanted) - set(self.names))
        if unknown:
            raise TrackingError(f"this detector finds {', '.join(self.names)}, not {unknown[0]!r}")
        try:
            detections = self.detect(frame)
        except DetectorError as error:
            raise TrackingError(str(error)) from error
        return [
            Hypothesis(each.part, each.camera_from_body, each.confidence)
            for each in detections.found
            if each.part in wanted
        ]

    def _posed(self, kept: Candidates, place: int, frame: Frame) -> Detection | Rejection | None:
        """A candidate with its pose; None for a class that is not to be found."""
        known = self._classes[int(kept.classes[place])]
        if known.part not in self._parts:
            return None
        keypoints = kept.keypoints[place]
        pixels = self._letterbox.to_image(keypoints[:, :2])
        presence = keypoints[:, 2]
        arrays = known.points, pixels, presence
        solved = pose_from_keypoints(*arrays, self.camera.color, self._parameters.pnp)
        if isinstance(solved, Rejection):
            return solved
        box_px = self._letterbox.to_image(kept.boxes[place].reshape(2, 2)).ravel()
        part = self._parts[known.part]
        placed = self._placed(solved, part, box_px)
        pose = self._ranged(placed, part, frame)
        score = float(kept.scores[place])
        return Detection(
            part=known.part,
            score=score,
            confidence=min(score, 1.0) * float(solved.is_inlier.mean()),
            box_px=box_px,
            keypoints_px=pixels,
            presence=presence,
            is_inlier=solved.is_inlier,
            error_px=solved.error_px,
            camera_from_body=pose or placed,
            is_ranged=pose is not None,
        )

    def _placed(self, solved: PnpPose, part: Part, box_px: Array) -> Pose:
        """Where the box says that the part is, if it says anything."""
        pose, settings = solved.camera_from_body, self._parameters.box
        if settings is None:
            return pose
        outline_m = part.mesh.hull_points
        return placed_by_box(pose, outline_m, box_px, self.camera.color, settings) or pose

    def _ranged(self, placed: Pose, part: Part, frame: Frame) -> Pose | None:
        settings = self._parameters.range
        if settings is None or frame.depth is None or self.camera.depth is None:
            return None
        return ranged(placed, part.mesh, frame.depth, self.camera, settings)
