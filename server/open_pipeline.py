"""Opens the source and the tracker of a station; the heavy imports are here. Workers only."""

from __future__ import annotations

from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from snapfit.models.asset import Asset, Part, find_asset
from snapfit.server.find_parts import detector_for, with_finding
from snapfit.server.pipeline import Image, Pipeline, Report
from snapfit.server.record_station import with_recording
from snapfit.server.worker_spec import AUTO, DEMO_SOURCE, WorkerSpec
from snapfit.tracking.errors import SourceError
from snapfit.tracking.kernel_threads import KernelThreads
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.sources import open_any
from snapfit.tracking.sources.base import Source
from snapfit.tracking.tracker import Tracker


def open_pipeline(spec: WorkerSpec, report: Report) -> Pipeline:
    """The source and the tracker of a station.

    A recording is played forwards and backwards for ever, so that poses never jump.

    Raises:
        SnapfitError: whatever is refused: the asset, the source, the method, the detector.
    """
    asset = None if spec.asset is None else find_asset(spec.asset)
    where = str(_demo(asset, report)) if spec.source == DEMO_SOURCE else spec.source
    report("opening the source", None)
    calibration = None if spec.calibration is None else Path(spec.calibration)
    source = open_any(where, asset, "pingpong", calibration)
    try:
        return _tracking(source, spec, report)
    except BaseException:
        source.close()
        raise


def chosen_method(wish: str, parts: Collection[Part], asset: Asset | None) -> str:
    """The method that is wished for; for "auto" the one that makes most of what is known.

    Args:
        wish: a method, or "auto".
        parts: that are tracked.
        asset: that is assembled; None for loose parts.
    """
    if wish != AUTO:
        return wish
    known = set() if asset is None or not asset.states else {part.name for part in asset.parts}
    return "gbot" if known and known >= {part.name for part in parts} else "icg"


def _tracking(source: Source, spec: WorkerSpec, report: Report) -> Pipeline:
    if not source.parts:
        raise SourceError(f"{source.name}: a camera knows no parts: set station.asset")
    method = chosen_method(spec.method, source.parts, source.asset)
    # Open3D takes a second to load: that goes on while the tracker is made.
    with ThreadPoolExecutor(1) as beside:
        detector = beside.submit(detector_for, spec, source)
        tracker = create_tracker(method, source.parts, source.camera, report, asset=source.asset)

    def draw(image: Image, result: TrackingResult) -> Image:
        return draw_overlay(image, source.camera.color, source.parts, result.parts)

    _draw_once(source)
    # Of the tracker proper: a part that it stops is one that the finder looks for.
    controls = TrackerControls(tracker) if isinstance(tracker, Tracker) else None
    threads = KernelThreads(1e3 / source.frame_rate_hz)
    pipeline = Pipeline(source, tracker, draw, method, controls=controls, threads=threads)
    if spec.record is None:
        return with_finding(pipeline, spec, detector.result(), report)
    return with_recording(pipeline, spec, detector.result(), report)


class TrackerControls:
    """What an operator can do to a `Tracker`."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker

    def set_state(self, state: str) -> None:
        """As in `Controls`."""
        self._tracker.set_state(state)

    def search(self, part: str) -> None:
        """As in `Controls`."""
        self._tracker.stop(part)


def _draw_once(source: Source) -> None:
    """Once now, so that the first picture does not wait for the compiler."""
    camera = source.camera.color
    blank = np.zeros((camera.height, camera.width, 3), dtype=np.uint8)
    poses = source.initial_poses.items()
    estimates = [PartEstimate(name, Status.TRACKED, 1.0, pose) for name, pose in poses]
    draw_overlay(blank, camera, source.parts, estimates)


def _demo(asset: Asset | None, report: Report) -> Path:
    from snapfit.models.workbench.demo import demo_sequence  # its renderer is for the demo alone

    if asset is None:
        raise SourceError("the simulated bench needs an asset: set station.asset")
    message = "rendering the simulated bench"
    report(message, None)
    return demo_sequence(asset, lambda share: report(message, share))
