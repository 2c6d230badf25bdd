"""Tracks through a recording as fast as it goes, and writes down what came out."""

from __future__ import annotations

import json
from collections.abc import Iterator

from snapfit.tracking.errors import FrameError, SourceError
from snapfit.tracking.frame import Frame
from snapfit.tracking.method import MethodTracker
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.sources.bad_frames import BadFrames
from snapfit.tracking.sources.base import Source


def track_source(
    source: Source, tracker: MethodTracker, bad_frames: BadFrames, *, finds_parts: bool = False
) -> Iterator[tuple[Frame, TrackingResult]]:
    """Tracks from the source's initial poses on; the first good frame is tracked too.

    Args:
        source: read to its end; not closed.
        tracker: for the source's parts and camera.
        bad_frames: is told of frames that are skipped.
        finds_parts: the tracker finds its parts by itself; the source's initial poses are not used.

    Raises:
        SourceError: the source declares no initial pose, or has no frame that can be used.
    """
    if not source.initial_poses and not finds_parts:
        problem = "no part has an initial pose to start from: add them, or choose a detector"
        raise SourceError(f"{source.name}: {problem}")
    started = False
    while True:
        try:
            frame = source.read()
            if frame is None:
                break
            if not started and not finds_parts:
                tracker.start(frame, source.initial_poses)
            result = tracker.track(frame)
            started = True
        except FrameError as error:
            bad_frames.add(error)
            continue
        yield frame, result
    if not started:
        raise SourceError(f"{source.name}: none of its frames can be used")


def result_lines(result: TrackingResult) -> Iterator[str]:
    """A line of JSON for each part of a frame, as `snapfit track --out` writes them."""
    for estimate in result.parts:
        pose = estimate.camera_from_body
        yield json.dumps(
            {
                "frame": result.frame,
                "part": estimate.part,
                "status": estimate.status.value,
                "confidence": round(estimate.confidence, 4),
                "camera_from_body": None if pose is None else pose.matrix.tolist(),
                "ms": round(result.duration_ms, 3),
            },
            allow_nan=False,
        )
