"""How well one part was tracked through a recording: counts, confidences, errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.recording import GroundTruth
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.metrics import add_m, add_s_m, model_vertices, quantile, recall
from snapfit.tracking.result import PartEstimate, Status

LEAST_VISIBILITY = 0.5
"""Errors are judged where at least this share of the part is visible."""


@dataclass(eq=False)
class PartEvaluation:
    """One part's record, frame by frame.

    A judged frame without an estimate has infinite errors.

    Attributes:
        part: the part.
        n_tracked: frames with the status `tracked`.
        n_lost: frames without a pose.
        n_frames: all frames.
        confidences: of frames with a pose, 0 to 1.
        translations_m, rotations_rad: errors with the symmetry taken out.
        adds_m: ADD-S of a symmetric part, ADD of any other, metres.
    """

    part: Part
    n_tracked: int = 0
    n_lost: int = 0
    n_frames: int = 0
    confidences: list[float] = field(default_factory=list)
    translations_m: list[float] = field(default_factory=list)
    rotations_rad: list[float] = field(default_factory=list)
    adds_m: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._points = model_vertices(self.part.mesh)
        self._tree = cKDTree(model_vertices(self.part.mesh, None))

    def add(self, estimate: PartEstimate, truth: GroundTruth | None) -> None:
        """Take in one frame; without truth it counts, but is not judged."""
        self.n_frames += 1
        self.n_tracked += estimate.status is Status.TRACKED
        if estimate.camera_from_body is None:
            self.n_lost += 1
        else:
            self.confidences.append(estimate.confidence)
        if truth is not None and self.part.name in truth.camera_from_body:
            self._judge(estimate, truth)

    @property
    def n_judged(self) -> int:
        """Frames whose errors are known."""
        return len(self.adds_m)

    @property
    def confidence(self) -> float:
        """Median over frames with a pose; not a number without any."""
        return quantile(np.array(self.confidences), 0.5)

    def translation_m(self, share: float) -> float:
        """The translation error that this share of judged frames does not exceed."""
        return quantile(np.array(self.translations_m), share)

    def rotation_rad(self, share: float) -> float:
        """The rotation error that this share of judged frames does not exceed."""
        return quantile(np.array(self.rotations_rad), share)

    def add_m(self, share: float) -> float:
        """The ADD(-S) that this share of judged frames does not exceed."""
        return quantile(np.array(self.adds_m), share)

    @property
    def add_recall(self) -> float:
        """Share of judged frames whose ADD(-S) is below a tenth of the diameter."""
        return recall(np.array(self.adds_m), 0.1 * self.part.mesh.diameter_m)

    def _judge(self, estimate: PartEstimate, truth: GroundTruth) -> None:
        name, symmetry = self.part.name, self.part.symmetry
        if truth.visibility.get(name, 1.0) < LEAST_VISIBILITY:
            return
        true = truth.camera_from_body[name]
        pose = estimate.camera_from_body
        translation_m = rotation_rad = error_m = math.inf
        if pose is not None:
            translation_m, rotation_rad = distance_modulo_symmetry(true, pose, symmetry)
            if symmetry.is_none:
                error_m = add_m(self._points, pose, true)
            else:
                error_m = add_s_m(self._points, pose, true, self._tree)
        self.translations_m.append(translation_m)
        self.rotations_rad.append(rotation_rad)
        self.adds_m.append(error_m)
