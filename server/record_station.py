"""Records what a station sees and says. Workers only."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

from snapfit.server.clock import Clock
from snapfit.server.find_parts import with_finding
from snapfit.server.pipeline import Pipeline, Recording, Report
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.finding.names import DetectorName
from snapfit.tracking.recording.account import RecordingAccount

_LOGGER = logging.getLogger("snapfit")


def with_recording(
    pipeline: Pipeline, spec: WorkerSpec, detector: DetectorName | None, report: Report
) -> Pipeline:
    """The pipeline with the station's detector, as `with_finding`, and its recording.

    Raises:
        RecordingError: the recording cannot be written.
        SnapfitError: as `with_finding`.
    """
    # The libraries of recordings are loaded where something is recorded alone.
    from snapfit.tracking.recording.events import EventLog
    from snapfit.tracking.recording.recorder import Recorder, new_path
    from snapfit.tracking.recording.station import loose_meshes, station_record
    from snapfit.tracking.recording.tracking import (
        LogToRecording,
        RecordingControls,
        RecordingTracker,
    )

    events = EventLog()
    pipeline = with_finding(pipeline, spec, detector, report, events)
    try:
        source = pipeline.source
        station = station_record(
            source,
            station=spec.station,
            method=pipeline.method,
            detector=pipeline.detector,
            finds=events.finds,
            color_format=spec.record_color,
        )
        now_ns = Clock(spec.wall_minus_monotonic_ns).now_ns()
        path = new_path(Path(spec.record or ""), spec.station, now_ns)
        recorder = Recorder.begin(path, station, loose_meshes(source), now_ns)
    except BaseException:
        if pipeline.finding is not None:
            pipeline.finding.close()
        raise
    controls = pipeline.controls
    return replace(
        pipeline,
        controls=None if controls is None else RecordingControls(controls, events),
        tracker=RecordingTracker(pipeline.tracker, events, recorder),
        recording=_LoggedRecording(recorder, LogToRecording(recorder)),
    )


class _LoggedRecording:
    """A recording that the log goes into as well."""

    def __init__(self, recording: Recording, handler: logging.Handler) -> None:
        self._recording, self._handler = recording, handler
        _LOGGER.addHandler(handler)

    @property
    def account(self) -> RecordingAccount:
        return self._recording.account

    def close(self) -> None:
        _LOGGER.removeHandler(self._handler)
        self._recording.close()
