"""Trackers that find their parts by themselves, by name."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Protocol, get_args

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.detector.card import ONNX_NAME
from snapfit.models.errors import DetectorError
from snapfit.tracking.body import Body
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.catch_up import CatchUp, CatchUpThread, ImmediateCatchUp
from snapfit.tracking.finding.finder import Finder
from snapfit.tracking.finding.joined import with_links
from snapfit.tracking.finding.lookout import DelayedLookout, Lookout, LookoutThread
from snapfit.tracking.finding.names import DetectorName
from snapfit.tracking.finding.parameters import SelfStartParameters
from snapfit.tracking.finding.reinitialised import DelayFrames
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.finding.turns import in_turn
from snapfit.tracking.finding.twins import twins_of
from snapfit.tracking.method import LATENCIES
from snapfit.tracking.methods import Progress, create_tracker
from snapfit.tracking.tracker import Tracker

_LOG = logging.getLogger(__name__)

DETECTORS: tuple[DetectorName, ...] = get_args(DetectorName)

# While all is seen, a look now and then is enough; it costs a core for as long as it takes.
_EVERY_S = {"geometric": 3.0, "network": 1.0}


class Noted(Protocol):
    """Stands in for what works beside a tracker, and notes its answers."""

    def lookout(self, lookout: Lookout) -> Lookout:
        """In place of this lookout."""

    def catch_up(self, catch_up: CatchUp) -> CatchUp:
        """In place of this one."""


def create_finder(
    detector: str,
    parts: Sequence[Part],
    bodies: Sequence[Body],
    camera: RgbdCamera,
    asset: Asset | None,
    providers: Sequence[str] = ("cpu",),
) -> Finder:
    """A finder by its name.

    Args:
        detector: one of `DETECTORS`: by shape in the depth image, or the asset's own network.
        parts, bodies: that are to be found, in one order.
        camera: where the frames come from.
        asset: in whose folder the network lies; the geometric detector needs none.
        providers: what runs a network, the first choice first; see `PROVIDERS` of the detection.

    Raises:
        TrackingError: there is no such detector or provider, or it cannot be used here.
        DetectorError: the asset has no network, or one that does not fit.
    """
    # Open3D and ONNX Runtime take seconds to load, and only one of them is used.
    if detector == "geometric":
        from snapfit.tracking.finding.geometric import GeometricFinder

        return GeometricFinder(bodies, camera)
    if detector == "network":
        from snapfit.tracking.detection.detector import Detector
        from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters
        from snapfit.tracking.detection.providers import providers_here
        from snapfit.tracking.finding.guidance import guided

        if asset is None:
            raise TrackingError("a network lies in an asset's bundle: name an asset")
        path = asset.directory / ONNX_NAME
        if not path.is_file():
            problem = f"is missing: snapfit train {asset.name} makes one; or choose geometric"
            raise DetectorError(path, problem)
        # One thread: the network looks beside the tracker. With a thread a core it would take
        # every core for a tenth of a second, and frames would come late; nobody waits for it.
        settings = DetectorParameters(
            range=RangeParameters(), providers=providers_here(providers), threads=1
        )
        network = Detector(asset.directory, parts, camera, settings)
        if network.provider != settings.providers[0]:
            _LOG.warning("%s does not start: %s runs", settings.providers[0], network.provider)
        return guided(network, bodies, camera)
    raise _unknown(detector)


def create_offline(
    method: str,
    detector: str,
    parts: Sequence[Part],
    camera: RgbdCamera,
    asset: Asset,
    frame_rate_hz: float,
    progress: Progress | None = None,
    providers: Sequence[str] = ("cpu",),
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
    tracker = _follower(method, create_tracker(method, parts, camera, progress, asset=asset))
    finder = create_finder(detector, parts, tracker.bodies, camera, asset, providers)
    lookout = in_turn(
        [
            DelayedLookout(each, DelayFrames(LATENCIES[kind], frame_rate_hz))
            for kind, each in _in_turn(detector, finder, tracker, asset)
        ]
    )
    catch_up = ImmediateCatchUp(Tracker(tracker.bodies, camera))
    twins = twins_of(parts, tracker.bodies, asset)
    return SelfStartingTracker(tracker, parts, lookout, catch_up=catch_up, twins=twins)


def create_live(
    tracker: Tracker,
    finder: Finder,
    detector: str,
    parts: Sequence[Part],
    frame_rate_hz: float,
    noted: Noted | None = None,
    asset: Asset | None = None,
) -> SelfStartingTracker:
    """A tracker for a camera: it never waits for the finder, which has threads of its own.

    Args:
        tracker: that follows the parts.
        finder: that looks for them, of the kind `detector`.
        parts: that are followed, in order.
        frame_rate_hz: of the camera.
        noted: stands between the tracker and those threads, where their answers are recorded.
        asset: whose links say where joined parts are; None: nothing is looked for there.
    """
    finders = _in_turn(detector, finder, tracker, asset)
    lookout = in_turn([LookoutThread(each) for _, each in finders])
    catch_up: CatchUp = CatchUpThread(Tracker(tracker.bodies, tracker.camera))
    if noted is not None:
        lookout, catch_up = noted.lookout(lookout), noted.catch_up(catch_up)
    return self_starting(tracker, lookout, catch_up, detector, parts, frame_rate_hz, asset)


def self_starting(
    tracker: Tracker,
    lookout: Lookout,
    catch_up: CatchUp,
    detector: str,
    parts: Sequence[Part],
    frame_rate_hz: float,
    asset: Asset | None,
) -> SelfStartingTracker:
    """A tracker that looks for its parts as often as this detector can look beside a camera."""
    every_frames = max(1, round(_EVERY_S[detector] * frame_rate_hz))
    parameters = SelfStartParameters(every_frames=every_frames)
    twins = twins_of(parts, tracker.bodies, asset)
    return SelfStartingTracker(tracker, parts, lookout, parameters, catch_up, twins)


def _in_turn(
    detector: str, finder: Finder, tracker: Tracker, asset: Asset | None
) -> list[tuple[str, Finder]]:
    """What looks, by its kind: beside a network that shapes guide, shape alone too."""
    finders: Sequence[tuple[str, Finder]] = [(detector, finder)]
    if detector == "network":
        from snapfit.tracking.finding.guidance import finders_in_turn

        finders = finders_in_turn(finder, tracker.bodies)
    return with_links(finders, tracker.bodies, tracker.camera, asset)


def _follower(method: str, tracker: object) -> Tracker:
    if not isinstance(tracker, Tracker):
        raise TrackingError(f"{method} finds parts by itself: it needs no detector beside")
    return tracker


def _unknown(detector: str) -> TrackingError:
    known = ", ".join(DETECTORS)
    return TrackingError(f"there is no detector {detector!r}; the detectors are {known}")
