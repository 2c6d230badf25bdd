"""Writes a recording for the Rerun viewer, to look at what went wrong and when."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.camera import PinholeCamera
from snapfit.tracking.errors import RecordingError
from snapfit.tracking.recording.reading import OpenRecording, RecordedResult
from snapfit.tracking.recording.records import ResultRecord, pose_of

_TIMELINE = "time"


def write_rerun(opened: OpenRecording, out: Path, asset: Asset | None = None) -> int:
    """Writes a file for the Rerun viewer; how many frames it has.

    Args:
        opened: the recording.
        out: the file, .rrd.
        asset: takes the place of the one that the recording names.

    Raises:
        RecordingError: rerun-sdk is not installed, the file cannot be written, or the
            recording's asset is not here.
    """
    rr = _rerun(out)
    if not out.absolute().parent.is_dir():
        raise RecordingError(out, f"there is no folder {out.absolute().parent}")
    stream = rr.RecordingStream("snapfit", recording_id=opened.path.stem)
    stream.save(str(out))
    stream.log("camera", rr.ViewCoordinates.RDF, static=True)
    camera = opened.camera
    stream.log("camera/color", _pinhole(rr, camera.color), static=True)
    if camera.depth is not None:
        stream.log("camera/depth", _transform(rr, camera.color_from_depth.matrix), static=True)
        stream.log("camera/depth", _pinhole(rr, camera.depth), static=True)
    for part in opened.parts(opened.asset(asset)):
        mesh = rr.Mesh3D(
            vertex_positions=part.mesh.vertices,
            triangle_indices=part.mesh.faces,
            albedo_factor=[*part.color_rgb, 255],
        )
        stream.log(f"camera/parts/{part.name}", mesh, static=True)
    for result in opened.results:
        at = np.datetime64(result.captured_at_ns, "ns")
        stream.set_time(_TIMELINE, timestamp=at)
        _log_images(rr, stream, opened, result)
        _log_result(rr, stream, opened.record(result))
    stream.disconnect()
    return len(opened.results)


def _rerun(out: Path) -> Any:
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        problem = f"needs the package rerun-sdk ({error}): pip install 'snapfit[rerun]'"
        raise RecordingError(out, problem) from error


def _pinhole(rr: Any, camera: PinholeCamera) -> Any:
    size = [camera.width, camera.height]
    return rr.Pinhole(image_from_camera=camera.matrix, resolution=size)


def _transform(rr: Any, matrix: Any) -> Any:
    return rr.Transform3D(translation=matrix[:3, 3], mat3x3=matrix[:3, :3])


def _log_images(rr: Any, stream: Any, opened: OpenRecording, result: RecordedResult) -> None:
    """The images as they were encoded, without decoding them."""
    color, depth = opened.encoded(result)
    if color is not None:
        kind = f"image/{opened.station.color_format}"
        stream.log("camera/color", rr.EncodedImage(contents=color, media_type=kind))
    if depth is not None:
        metre = 1.0 / opened.camera.depth_scale_m
        image = rr.EncodedDepthImage(blob=depth, media_type="image/png", meter=metre)
        stream.log("camera/depth", image)


def _log_result(rr: Any, stream: Any, record: ResultRecord) -> None:
    for each in record.parts:
        entity = f"camera/parts/{each.part}"
        if each.camera_from_body is None:
            stream.log(entity, rr.Transform3D(scale=0.0))
        else:
            stream.log(entity, _transform(rr, pose_of(each.camera_from_body).matrix))
        stream.log(f"confidence/{each.part}", rr.Scalars(each.confidence or 0.0))
    if record.duration_ms is not None:
        stream.log("duration_ms", rr.Scalars(record.duration_ms))
    told = [f"{event.kind} {event.frame}{', '.join(event.poses)}" for event in record.events]
    for text in [*told, *filter(None, [record.error])]:
        stream.log("events", rr.TextLog(text))
