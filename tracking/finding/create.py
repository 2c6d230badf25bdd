"""Trackers that find their parts by themselves, by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.tracking.body import Body
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import Finder
from snapfit.tracking.finding.lookout import DelayedLookout
from snapfit.tracking.finding.reinitialised import delay_frames
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.method import GEOMETRIC_LATENCY_S, NETWORK_LATENCY_S
from snapfit.tracking.methods import Progress, create_tracker
from snapfit.tracking.tracker import Tracker

DetectorName = Literal["geometric", "network"]
DETECTORS: tuple[DetectorName, ...] = get_args(DetectorName)

_LATENCY_S = {"geometric": GEOMETRIC_LATENCY_S, "network": NETWORK_LATENCY_S}


def create_finder(
    detector: str, parts: Sequence[Part], bodies: Sequence[Body], camera: RgbdCamera, asset: Asset
) -> Finder:
    """A finder by its name.

    Args:
        detector: one of `DETECTORS`: by shape in the depth image, or the asset's own network.
        parts, bodies: that are to be found, in one order.
        camera: where the frames come from.
        asset: in whose folder the network lies.

    Raises:
        TrackingError: there is no such detector, or it cannot be used here.
        DetectorError: the asset has no network, or one that does not fit.
    """
    # Open3D and ONNX Runtime take seconds to load, and only one of them is used.
    if detector == "geometric":
        from snapfit.tracking.finding.geometric import GeometricFinder

        return GeometricFinder(bodies, camera)
    if detector == "network":
        from snapfit.tracking.detection.detector import Detector
        from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters

        settings = DetectorParameters(range=RangeParameters(), threads=1)
        return Detector(asset.directory, parts, camera, settings)
    raise _unknown(detector)


def create_offline(
    method: str,
    detector: str,
    parts: Sequence[Part],
    camera: RgbdCamera,
    asset: Asset,
    frame_rate_hz: float,
    progress: Progress | None = None,
) -> SelfStartingTracker:
    """A tracker for a recording that is read as fast as it goes, the same in each run.

    What the detector sees is told as many frames later as a camera would have delivered meanwhile.

    Raises:
        TrackingError: there is no such method or detector, the method follows no poses, or the
            detector cannot be used here.
        DetectorError: the asset has no network, or one that does not fit.
        ViewpointModelError: a viewpoint model can neither be read nor made.
    """
    if detector not in DETECTORS:
        raise _unknown(detector)
    tracker = create_tracker(method, parts, camera, progress, asset=asset)
    if not isinstance(tracker, Tracker):
        raise TrackingError(f"{method} finds parts by itself: it needs no detector beside")
    finder = create_finder(detector, parts, tracker.bodies, camera, asset)
    lookout = DelayedLookout(finder, delay_frames(_LATENCY_S[detector], frame_rate_hz))
    follower = Tracker(tracker.bodies, camera)
    return SelfStartingTracker(tracker, parts, lookout, follower=follower)


def _unknown(detector: str) -> TrackingError:
    known = ", ".join(DETECTORS)
    return TrackingError(f"there is no detector {detector!r}; the detectors are {known}")
