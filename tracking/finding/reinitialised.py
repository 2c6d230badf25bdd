"""Trackers with a detector beside, made for recordings: the same answers in each run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module

from snapfit.models.asset import Asset, Part
from snapfit.tracking.finding.catch_up import ImmediateCatchUp
from snapfit.tracking.finding.finder import Finder
from snapfit.tracking.finding.joined import with_links
from snapfit.tracking.finding.lookout import DelayedLookout
from snapfit.tracking.finding.paper_reinit import PaperReinitialisation
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.finding.turns import in_turn
from snapfit.tracking.finding.twins import twins_of
from snapfit.tracking.method import FINDERS, LATENCIES, NETWORK, Latency, ReinitialisedMethod
from snapfit.tracking.tracker import Tracker

_SLACK_FRAMES = 1e-6


def reinitialised(
    tracker: Tracker,
    method: ReinitialisedMethod,
    parts: Sequence[Part],
    asset: Asset,
    frame_rate_hz: float,
) -> SelfStartingTracker | PaperReinitialisation:
    """A tracker with a detector beside, as a method has it.

    Args:
        tracker: that follows the parts.
        method: says which detector, and how what it finds is used.
        parts: that are tracked, in the tracker's order.
        asset: in whose folder the network lies.
        frame_rate_hz: of the frames.

    Raises:
        TrackingError: the detector cannot be used here.
        DetectorError: the asset has no network, or one that does not fit.
    """
    finder = _finder(tracker, method, parts, asset)
    if method.is_published:
        return PaperReinitialisation(tracker, finder)
    finders: Sequence[tuple[str, Finder]] = [(method.detector, finder)]
    if method.detector == "network":
        finders = import_module(FINDERS["network"]).finders_in_turn(finder, tracker.bodies)
    lookout = in_turn(
        [
            DelayedLookout(each, DelayFrames(LATENCIES[kind], frame_rate_hz))
            for kind, each in with_links(finders, tracker.bodies, tracker.camera, asset)
        ]
    )
    catch_up = ImmediateCatchUp(Tracker(tracker.bodies, tracker.camera))
    twins = twins_of(parts, tracker.bodies, asset)
    return SelfStartingTracker(tracker, parts, lookout, catch_up=catch_up, twins=twins)


@dataclass(frozen=True)
class DelayFrames:
    """How many frames later a detector's answer comes, by the number of parts that it looks for.

    Args:
        latency: of the detector.
        frame_rate_hz: of the camera.
    """

    latency: Latency
    frame_rate_hz: float

    def __call__(self, n_parts: int) -> int:
        """The delay with so many parts."""
        return delay_frames(self.latency.of_parts_s(n_parts), self.frame_rate_hz)


def delay_frames(latency_s: float, frame_rate_hz: float) -> int:
    """How many frames later an answer comes that took some seconds; at the next frame at least.

    What is ready between two frames is used in the later one: 60 ms are 2 frames at 30 Hz.
    """
    # 0.1 s at 30 Hz are 3.0000000000000004 frames in floating point.
    return max(1, math.ceil(latency_s * frame_rate_hz - _SLACK_FRAMES))


def _finder(
    tracker: Tracker, method: ReinitialisedMethod, parts: Sequence[Part], asset: Asset
) -> Finder:
    # By their names: neither is loaded for the other, nor belongs to the other's finished runs.
    if method.detector == "geometric":
        geometric = import_module(FINDERS["geometric"])
        by_shape: Finder = geometric.GeometricFinder(tracker.bodies, tracker.camera)
        return by_shape
    from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters

    measured = RangeParameters() if method.uses_depth else None
    # One thread: live it looks beside the tracker, which needs the other cores.
    settings = DetectorParameters(range=measured, threads=1)
    network: Finder = import_module(NETWORK).Detector(
        asset.directory, parts, tracker.camera, settings
    )
    if not method.uses_depth:
        return network
    by_both: Finder = import_module(FINDERS["network"]).guided(
        network, tracker.bodies, tracker.camera
    )
    return by_both
