"""The free numbers of detection."""

from __future__ import annotations

from dataclasses import dataclass, field

CPU = "CPUExecutionProvider"


@dataclass(frozen=True)
class CandidateParameters:
    """Which anchors count, and which of them are the same part.

    Attributes:
        least_score: of an anchor's best class.
        same_overlap: intersection over union from which on two candidates are one part.
        most_candidates: only so many of the best are looked at.
        most_instances: of each class, at most.
    """

    least_score: float = 0.25
    same_overlap: float = 0.6
    most_candidates: int = 300
    most_instances: int = 3


@dataclass(frozen=True)
class PnpParameters:
    """How a pose is made of keypoints.

    Attributes:
        threshold_px: a keypoint is an inlier that is no farther off (GBOT's reference: 12 px).
        iterations: of RANSAC, at most.
        sureness: probability with which RANSAC is to have found a set without outliers.
        least_presence: keypoints that are less surely in the image are left out.
        least_inliers: with fewer the pose is rejected.
        nearest_m, farthest_m: of the part's centre from the camera; others are rejected.
    """

    threshold_px: float = 12.0
    iterations: int = 200
    sureness: float = 0.999
    least_presence: float = 0.2
    least_inliers: int = 6
    nearest_m: float = 0.05
    farthest_m: float = 5.0


@dataclass(frozen=True)
class BoxParameters:
    """How the box that a part was found in fixes where it is.

    Attributes:
        fills: intersection over union of the drawn outline's box and the one found from which on
            the pose stays as PnP has it.
        border_px: a side of the box that is no farther from the image's border is cut off there.
        rounds: of Gauss-Newton.
        nearest_m: no point of the part may come nearer.
    """

    fills: float = 0.9
    border_px: float = 2.0
    rounds: int = 6
    nearest_m: float = 0.02


@dataclass(frozen=True)
class RangeParameters:
    """How measured depth fixes a part's distance.

    Attributes:
        scale: of the image in which the part is drawn for comparison.
        window: how far the measured distance may be from that of PnP, as a share of it.
        agreement_m: depth of a pixel agrees with the rest if it is no farther off.
        least_pixels: that have to agree.
        least_share: of the part's pixels that have to agree.
        rounds: how often the part is drawn anew where it was found to be.
    """

    scale: float = 0.25
    window: float = 0.35
    agreement_m: float = 0.006
    least_pixels: int = 8
    least_share: float = 0.2
    rounds: int = 2


@dataclass(frozen=True)
class DetectorParameters:
    """All of a detector.

    Attributes:
        candidates, pnp: as their types say.
        box: how the box is used; None for keypoints alone.
        range: how depth is used; None for colour alone.
        providers: of ONNX Runtime, the first that there is; the CPU if none of them.
        threads: of ONNX Runtime; 0: one a core.
    """

    candidates: CandidateParameters = field(default_factory=CandidateParameters)
    pnp: PnpParameters = field(default_factory=PnpParameters)
    box: BoxParameters | None = field(default_factory=BoxParameters)
    range: RangeParameters | None = None
    providers: tuple[str, ...] = (CPU,)
    threads: int = 0
