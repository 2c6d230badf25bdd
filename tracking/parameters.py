"""The numeric parameters of the trackers. Defaults after Stoiber et al. (SRT3D, ICG, M3T) and GBOT.

Every value that changes from one correspondence iteration to the next is a tuple, coarse to fine;
its last entry repeats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from snapfit.tracking.errors import TrackingError

FUNCTION_LENGTH = 8
"""Taps of the smoothed step functions (SRT3D)."""
DISTRIBUTION_LENGTH = 12
"""Bins of the discrete posterior over a line's contour offset."""
LINE_SEGMENTS = FUNCTION_LENGTH + DISTRIBUTION_LENGTH - 1
"""Segments of a correspondence line."""


@dataclass(frozen=True)
class RegionParameters:
    """The region modality (SRT3D).

    Attributes:
        lines_max: correspondence lines of a body at most.
        scales_px: pixels of a segment, along the dominant image axis.
        standard_deviations_px: of the contour's place, an iteration.
        min_continuous_distance: foreground and background a line needs on both sides, segments.
        amplitude: of the smoothed step functions, between 0 and 0.5.
        slope: of the smoothed step functions, segments.
        learning_rate: factor on the local gradient of the posterior.
        outlying: standard deviations at which a line's weight is halved (Cauchy): a shadow or a
            reflection beside the contour does not pull at the pose for long.
        global_updates: first updates of an iteration that use mean and variance of the posterior.
    """

    lines_max: int = 300
    scales_px: tuple[int, ...] = (6, 4, 2, 2, 1)
    standard_deviations_px: tuple[float, ...] = (15.0, 5.0, 3.5, 1.5)
    min_continuous_distance: float = 3.0
    amplitude: float = 0.43
    slope: float = 0.5
    learning_rate: float = 1.3
    outlying: float = 1.0
    global_updates: int = 1

    def __post_init__(self) -> None:
        if not 0 < self.amplitude < 0.5:
            raise TrackingError(f"amplitude is {self.amplitude}: it must lie between 0 and 0.5")
        if not self.scales_px or min(self.scales_px) < 1:
            raise TrackingError(f"scales_px is {self.scales_px}: each must be 1 px or more")

    @property
    def min_variance(self) -> float:
        """Smallest variance that a posterior may claim, segments squared (SRT3D)."""
        laplace = 1.0 / (2.0 * math.atanh(2.0 * self.amplitude) ** 2)
        return max(laplace, self.slope)


@dataclass(frozen=True)
class DepthParameters:
    """The depth modality (ICG): point to plane against the closest measured point.

    Attributes:
        points_max: surface points of a body at most.
        considered_distances_m: how far away a measured point may lie, at 1 m distance.
        standard_deviations_m: of a measured point, at 1 m distance.
        strides_m: spacing of the samples of the search window, at 1 m distance.
        least_scale: the deviations shrink to this share where the sensor proves to be good ...
        noise: ... that is, where so many root mean squares of the last errors are less.
        trusted_share: of the visible points with a measured one, for them to prove anything.
        beside, beside_slope: how far the closest point may lie beside the normal, in strides and
            as a share of its distance along the normal: what is found at the border of a hole in
            the depth image, or on another thing, is no correspondence.
    """

    points_max: int = 300
    considered_distances_m: tuple[float, ...] = (0.05, 0.02, 0.01)
    standard_deviations_m: tuple[float, ...] = (0.05, 0.03, 0.01, 0.012)
    strides_m: tuple[float, ...] = (0.01, 0.005)
    least_scale: float = 0.33
    noise: float = 3.0
    trusted_share: float = 0.5
    beside: float = 2.0
    beside_slope: float = 0.5


@dataclass(frozen=True)
class HistogramParameters:
    """The colour histograms: 16 bins a channel, foreground and background.

    Attributes:
        foreground_rate, background_rate: share of the newest frame, 0 to 1.
        unconsidered_length_px: left out on both sides of the contour; there a lens mixes both
            colours, and learning the mixture would let the contour creep.
        considered_length_px: sampled on both sides at most.
        shared: one pair of histograms for all bodies.
    """

    foreground_rate: float = 0.2
    background_rate: float = 0.2
    unconsidered_length_px: float = 1.0
    considered_length_px: float = 20.0
    shared: bool = False


@dataclass(frozen=True)
class OcclusionParameters:
    """What hides a part: measured (a hand, in the depth image), modelled (another tracked part).

    Attributes:
        measured, modelled: whether each is looked at.
        radius_m: around a contour or surface point.
        measured_threshold_m: how much nearer than the model something measured must be where the
            pose is rough ...
        held_threshold_m: ... and where it is known well: a hand lies on the part that it holds.
        modelled_threshold_m: how much nearer another tracked part must be.
        region_checking: another tracked part of like colour beyond the contour makes it none: the
            edge between two joined parts of one colour cannot be seen.
        image_scale: size of the modelled rendering, in colour image sizes.
        faces_max: faces of a part in the modelled rendering.
    """

    measured: bool = True
    modelled: bool = True
    region_checking: bool = False
    radius_m: float = 0.005
    measured_threshold_m: float = 0.035
    held_threshold_m: float = 0.035
    modelled_threshold_m: float = 0.005
    image_scale: float = 0.25
    faces_max: int = 800


@dataclass(frozen=True)
class OptimiserParameters:
    """Newton's method with Tikhonov regularisation.

    Attributes:
        correspondence_iterations: searches for correspondences a frame.
        update_iterations: Newton steps for each.
        tikhonov_rotation: regularisation of the rotation, 1/rad^2.
        tikhonov_translation: regularisation of the translation, 1/m^2.
    """

    correspondence_iterations: int = 6
    update_iterations: int = 2
    tikhonov_rotation: float = 1000.0
    tikhonov_translation: float = 30000.0


@dataclass(frozen=True)
class StartParameters:
    """How a rough first pose is refined.

    Attributes:
        margins_px: the pose is refined and the colours learned in turns; what lies this near to
            the contour is not learned, because the first poses may be off by so much.
        rotation_deg: hypotheses are turned by this about each axis of the body ...
        distance_m: ... and moved by this to and from the camera.
    """

    margins_px: tuple[float, ...] = (2.0,) * 8
    rotation_deg: float = 8.0
    distance_m: float = 0.012


@dataclass(frozen=True)
class LossParameters:
    """When a part counts as hidden, as doubtful and as lost.

    Attributes:
        hidden_evidence: with fewer lines and points than this, a part is hidden ...
        hidden_visibility: ... and so it is where less of it is unoccluded.
        lost_confidence: below this the pose contradicts what is seen ...
        lost_after_frames: ... and when it has done so for this long, the part is lost.
        doubt: with less than this share of its usual confidence a pose is not believed: what is
            seen is then a hand, or the part from a side that was not expected.
        doubt_frames: so long; then what is seen becomes the usual, ...
        believable: ... if its confidence is more than this; else the part is lost.
        usual_rate: share of the newest frame in the usual confidence.
    """

    hidden_evidence: int = 20
    hidden_visibility: float = 0.1
    lost_confidence: float = 0.15
    lost_after_frames: int = 10
    doubt: float = 0.0
    doubt_frames: int = 60
    believable: float = 0.5
    usual_rate: float = 0.1


@dataclass(frozen=True)
class MotionParameters:
    """The motion prior: constant velocity, damped.

    Attributes:
        damping: share of the last motion that is expected again; 0 switches the prior off.
        least_turn_rad: what turns by less ...
        least_way_m: ... and moves by less is at rest, and stays there.
    """

    damping: float = 0.8
    least_turn_rad: float = 0.01
    least_way_m: float = 0.001


NO_MOTION = MotionParameters(damping=0.0)


@dataclass(frozen=True)
class CovarianceParameters:
    """What a pose's covariance is made of beside the Hessian.

    The Hessian knows the scatter of lines and points alone, so more of them would make any pose
    certain. What all of them share is added: the error of the depth camera, above all.

    Attributes:
        information: factor on the Hessian. The modalities' deviations are set for convergence and
            are larger than the errors at the end, which makes it more than 1, although neighbouring
            lines and points share some of theirs.
        prior_rotation_rad, prior_translation_m: of a body of which nothing is seen.
        systematic_distance: of the distance from the camera, a share of it.
        systematic_place_m: of the place, in every direction: pictures, meshes, calibration.
        systematic_turn_rad: of the rotation, about every axis.
        unseen_turn_rad, unseen_way_m: how much further off a part that is not seen can be after
            each frame, about and along each axis.
    """

    information: float = 2.0
    prior_rotation_rad: float = 0.5
    prior_translation_m: float = 0.1
    systematic_distance: float = 0.0015
    systematic_place_m: float = 0.00035
    systematic_turn_rad: float = 0.002
    unseen_turn_rad: float = 0.01
    unseen_way_m: float = 0.0015

    def __post_init__(self) -> None:
        for name in ("information", "prior_rotation_rad", "prior_translation_m"):
            if not getattr(self, name) > 0:
                raise TrackingError(f"{name} is {getattr(self, name)}: it must be above 0")


@dataclass(frozen=True)
class ConfidenceParameters:
    """How probable it is that a pose is right, that is, its ADD(-S) below 10 % of the diameter.

    These are `icg`'s; what a method's evidence is worth depends on how it gets lost, so `gbot` and
    `srt3d` have theirs in `methods.py`. All were fitted by likelihood to simulated sequences of
    seed 21 (`normal`, `hand`), wrong stretches counting as 60 frames at most;
    docs/benchmark.md judges them on another seed.

    Attributes:
        middle: share of agreeing evidence at which a tracked pose is as likely right as wrong ...
        steepness: ... and the growth of the logarithm of its odds, for the whole evidence.
        best: the most that is ever claimed.
        sure: a tracked pose that is so probably right is remembered ...
        memory_frames: ... and a part that is not seen is still there for so long, on average.
    """

    middle: float = 0.62
    steepness: float = 10.0
    best: float = 0.998
    sure: float = 0.5
    memory_frames: float = 30.0

    def __post_init__(self) -> None:
        if not (self.steepness > 0 and self.memory_frames > 0):
            raise TrackingError(
                f"steepness is {self.steepness}, memory_frames {self.memory_frames}: "
                "both must be above 0"
            )


@dataclass(frozen=True)
class TrackerParameters:
    """All that a tracker needs to know beside bodies and cameras.

    Attributes:
        refined_by_region: the pose is refined once more, by the region modality alone.
        regains: lost parts are looked for by their colours.
    """

    region: RegionParameters | None = field(default_factory=RegionParameters)
    depth: DepthParameters | None = field(default_factory=DepthParameters)
    histogram: HistogramParameters = field(default_factory=HistogramParameters)
    occlusion: OcclusionParameters = field(default_factory=OcclusionParameters)
    optimiser: OptimiserParameters = field(default_factory=OptimiserParameters)
    start: StartParameters = field(default_factory=StartParameters)
    motion: MotionParameters = NO_MOTION
    loss: LossParameters = field(default_factory=LossParameters)
    covariance: CovarianceParameters = field(default_factory=CovarianceParameters)
    confidence: ConfidenceParameters = field(default_factory=ConfidenceParameters)
    refined_by_region: bool = False
    regains: bool = False

    def __post_init__(self) -> None:
        if self.region is None and self.depth is None:
            raise TrackingError("a tracker needs the region modality, the depth modality, or both")


def per_iteration(values: Sequence[float], iterations: int) -> list[float]:
    """The value of each correspondence iteration; the last one given repeats.

    Raises:
        TrackingError: there is no value.
    """
    if not values:
        raise TrackingError("a parameter of the iterations has no value: give at least one")
    return [float(values[min(i, len(values) - 1)]) for i in range(iterations)]
