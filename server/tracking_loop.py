"""The worker's loop: wait for the frame's time, read it, track it, publish it."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from pathlib import Path
from typing import Literal

from snapfit.models.asset import Asset
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import PoseError
from snapfit.models.pose import Pose
from snapfit.server.asset_export import export_asset
from snapfit.server.clock import Clock
from snapfit.server.command_runner import CommandRunner
from snapfit.server.marker_watch import MarkerWatch
from snapfit.server.pacer import Pacer
from snapfit.server.pictures import PictureMaker
from snapfit.server.pipeline import Pipeline
from snapfit.server.pose_store import PoseStore
from snapfit.server.reporter import Reporter
from snapfit.server.schemas import CameraInfo, Phase, StationFacts
from snapfit.server.snapshot import SnapshotWriter
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.errors import FrameError
from snapfit.tracking.frame import Frame
from snapfit.tracking.sources.base import is_live

_LOG = logging.getLogger(__name__)


class TrackingLoop:
    """Tracks frame after frame until told to stop."""

    def __init__(
        self,
        spec: WorkerSpec,
        pipeline: Pipeline,
        store: PoseStore,
        reporter: Reporter,
        clock: Clock,
    ) -> None:
        self._pipeline = pipeline
        self._store = store
        self._reporter = reporter
        self._clock = clock
        self._boot_id = spec.boot_id
        # Who finds the parts by himself needs no first pose: they are `searching` until then.
        self._started = pipeline.finding is not None
        facts = _facts(pipeline)
        self._snapshots = SnapshotWriter(
            station=spec.station, asset=facts.asset, boot_id=spec.boot_id, clock=clock
        )
        self._commands = CommandRunner(store, pipeline, self._snapshots)
        reporter.knows(facts, _exported(pipeline.source.asset))
        _LOG.info(
            "station %s: tracking %d parts of %s with %s at %g frames a second",
            spec.station,
            len(facts.parts),
            facts.asset or facts.source,
            facts.method,
            facts.frame_rate_hz,
        )

    def run(self, stop: threading.Event) -> None:
        """Until `stop`; after the source's end only the pictures go on.

        Raises:
            TrackingError: tracking cannot be started from the source's initial poses.
        """
        pictures = PictureMaker(self._store, self._pipeline)
        markers = MarkerWatch(
            self._store,
            self._boot_id,
            self._pipeline.source.camera.color,
            lambda: self._commands.orders.boards,
        )
        pacer = None
        if not is_live(self._pipeline.source):
            pacer = Pacer(self._pipeline.source.frame_rate_hz)
        self._reporter.report(Phase.STARTING, "waiting for the first frame")
        try:
            while not stop.is_set():
                due_ns = None if pacer is None else pacer.wait(stop)
                self._commands.run()
                if not self._next_frame(due_ns, pictures, markers):
                    self._reporter.report(Phase.ENDED, "the source has ended")
                    break
                self._commands.reply()
                self._reporter.beat()
            while not stop.wait(timeout=0.1):
                self._commands.run(ended=True)
                self._commands.reply()
                self._reporter.beat()
        finally:
            pictures.close()
            markers.close()

    def _next_frame(self, due_ns: int | None, pictures: PictureMaker, markers: MarkerWatch) -> bool:
        """One frame, from the source to the store; False at the source's end."""
        try:
            frame = self._pipeline.source.read()
        except FrameError as error:
            self._reporter.bad_frame(error.frame, error.problem)
            return True
        if frame is None:
            return False
        # A recording's own stamps are of another day: its frames are exposed as they are played.
        # Those of a camera carry their own time.
        at_ns = frame.captured_at_ns if due_ns is None else due_ns
        at_ns += self._clock.wall_minus_monotonic_ns
        frame = replace(frame, captured_at_ns=at_ns)
        markers.offer(frame)
        self._track(frame, pictures)
        return True

    def _track(self, frame: Frame, pictures: PictureMaker) -> None:
        tracker = self._pipeline.tracker
        try:
            if not self._started:
                tracker.start(frame, self._pipeline.source.initial_poses)
                self._started = True
            result = tracker.track(frame)
        except FrameError as error:
            self._reporter.bad_frame(error.frame, error.problem)
            return
        except PoseError as error:
            self._reporter.bad_frame(frame.name, str(error))
            return
        generation = self._store.snapshots.write(self._snapshots.write(result))
        self._store.doorbell.ring()
        self._commands.tracked(result)
        self._reporter.tracked(result.duration_ms)
        if self._pipeline.threads is not None:
            self._pipeline.threads.tracked(result.duration_ms)
        if self._pipeline.finding is not None:
            self._reporter.looked(self._pipeline.finding.account)
        if self._pipeline.recording is not None:
            self._reporter.recorded(self._pipeline.recording.account)
        pictures.offer(frame, result, generation)


def _exported(asset: Asset | None) -> Path | None:
    """The folder from which the API serves the asset; None where that cannot be written."""
    if asset is None:
        return None
    try:
        return export_asset(asset)
    except OSError as error:  # poses are served all the same
        _LOG.warning("asset %s: its steps and meshes cannot be served: %s", asset.name, error)
        return None


def _facts(pipeline: Pipeline) -> StationFacts:
    source = pipeline.source
    return StationFacts(
        asset=source.asset.name if source.asset else None,
        source=source.name,
        method=pipeline.method,
        detector=pipeline.detector or "none",
        provider=pipeline.provider,
        frame_rate_hz=source.frame_rate_hz,
        parts=[part.name for part in source.parts if part.tracked],
        cameras=_cameras(source.camera),
    )


def _cameras(camera: RgbdCamera) -> list[CameraInfo]:
    cameras = [_camera("color", camera.color, Pose.identity())]
    if camera.depth is not None:
        cameras.append(_camera("depth", camera.depth, camera.color_from_depth))
    return cameras


def _camera(
    name: Literal["color", "depth"], camera: PinholeCamera, color_from_camera: Pose
) -> CameraInfo:
    return CameraInfo(
        name=name,
        width=camera.width,
        height=camera.height,
        fx=camera.fx,
        fy=camera.fy,
        cx=camera.cx,
        cy=camera.cy,
        distortion=[],
        color_from_camera=color_from_camera.matrix.tolist(),
    )
