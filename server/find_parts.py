"""Lets a station's tracker find its parts by itself. Workers only."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from snapfit.server.pipeline import Pipeline, Report
from snapfit.server.worker_spec import AUTO, WorkerSpec
from snapfit.tracking.detection.providers import short_name
from snapfit.tracking.errors import SourceError, TrackingError
from snapfit.tracking.finding.choice import chosen_detector
from snapfit.tracking.finding.create import Noted, create_finder, create_live
from snapfit.tracking.finding.names import DetectorName
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.sources.base import Source
from snapfit.tracking.tracker import Tracker


def detector_for(spec: WorkerSpec, source: Source) -> DetectorName | None:
    """The station's detector, its library loaded where that takes long; None without one."""
    bundle = None if source.asset is None else source.asset.directory
    has_depth = source.camera.depth is not None
    detector = chosen_detector(spec.detector, bundle, has_depth=has_depth)
    if detector == "geometric":
        with suppress(TrackingError):  # told when it is made
            open3d()
    return detector


def with_finding(
    pipeline: Pipeline,
    spec: WorkerSpec,
    detector: DetectorName | None,
    report: Report,
    noted: Noted | None = None,
) -> Pipeline:
    """The pipeline with the station's detector beside its tracker, where there is one.

    Args:
        pipeline: whose tracker is made and has not been started.
        spec: of the station.
        detector: of the station, as `detector_for` has it.
        report: told that the detector is made.
        noted: notes the detector's answers, where they are recorded.

    Raises:
        SourceError: nothing finds the parts, and the source brings no initial pose.
        TrackingError: the detector cannot be used here, or not beside this method.
        DetectorError: the asset's network is missing, damaged, or does not fit.
    """
    source, tracker = pipeline.source, pipeline.tracker
    if not isinstance(tracker, Tracker):
        if spec.detector in (AUTO, "none"):
            return pipeline
        raise TrackingError(
            f"{pipeline.method} finds the parts in every frame: it needs no detector beside, set "
            "station.detector to none"
        )
    if detector is None:
        if not source.initial_poses:
            raise SourceError(
                f"{source.name}: no part has an initial pose to start from, and no detector finds "
                "them: add poses, or choose a detector (station.detector)"
            )
        return pipeline
    report("loading the detector", None)
    parts = [part for part in source.parts if part.name in tracker.names]
    finder = create_finder(
        detector, parts, tracker.bodies, source.camera, source.asset, spec.providers
    )
    finding = create_live(
        tracker, finder, detector, parts, source.frame_rate_hz, noted, source.asset
    )
    # Only a network has one.
    provider: str | None = getattr(finder, "provider", None)
    return replace(
        pipeline,
        tracker=finding,
        finding=finding,
        detector=detector,
        provider=None if provider is None else short_name(provider),
    )
