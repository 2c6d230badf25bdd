"""A recording as a file: which channels it has, and what is written for a frame."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import orjson
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import RecordingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording import foxglove
from snapfit.tracking.recording.images import encode_color
from snapfit.tracking.recording.mcap_writer import McapWriter
from snapfit.tracking.recording.png import encode_png
from snapfit.tracking.recording.records import (
    CALIBRATION_TOPICS,
    COLOR_FRAME,
    COLOR_TOPIC,
    DEPTH_FRAME,
    DEPTH_TOPIC,
    LOG_TOPIC,
    RESULT_TOPIC,
    STATION_TOPIC,
    TRANSFORMS_TOPIC,
    ResultRecord,
    StationRecord,
    camera_of,
    pose_of,
    pose_topic,
)


class RecordingFile:
    """A file in the making. Of each frame it has a chunk with the images and one with the rest.

    So what was said can be read without the images. Chunks are written whole.

    Attributes:
        path: the file.
    """

    def __init__(
        self, path: Path, station: StationRecord, meshes: Mapping[str, bytes], time_ns: int
    ) -> None:
        """Begins a file with what is known before the first frame.

        Args:
            path: the file; its folder is made.
            station: what is known.
            meshes: of loose parts, by part, as attachments.
            time_ns: now, Unix time.

        Raises:
            RecordingError: the file is there already, or cannot be written.
        """
        self.path, self._station = path, station
        self._camera = camera_of(station)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = McapWriter(path)
            for name, data in meshes.items():
                self._writer.attach(f"{name}.npz", "application/x-npz", data, time_ns)
            self._add_channels()
            self._write_station(time_ns)
        except OSError as error:
            raise RecordingError(path, f"cannot be written: {error.strerror}") from error

    @property
    def n_bytes(self) -> int:
        """How much is written."""
        return self._writer.n_bytes

    def write_frame(self, fields: Mapping[str, Any], frame: Frame | None, beside: Executor) -> None:
        """Writes a frame.

        Args:
            fields: of a `ResultRecord`, without `has_images`.
            frame: its images; None where they are left out.
            beside: encodes the depth image meanwhile.

        Raises:
            OSError: it cannot be written; the file ends with the frame before.
        """
        time_ns = int(fields["captured_at_ns"])
        if frame is not None:
            self._add_images(frame, time_ns, beside)
            self._writer.end_chunk()
        told = {**fields, "has_images": frame is not None}
        self._add(RESULT_TOPIC, time_ns, orjson.dumps(told))
        poses = {
            each["part"]: pose_of(each["camera_from_body"])
            for each in fields.get("parts", ())
            if each["camera_from_body"] is not None
        }
        for part, pose in poses.items():
            self._add(pose_topic(part), time_ns, foxglove.pose_in_frame(time_ns, COLOR_FRAME, pose))
        if poses:
            self._add(TRANSFORMS_TOPIC, time_ns, foxglove.transforms(time_ns, COLOR_FRAME, poses))
        self._writer.end_chunk()

    def write_log(self, time_ns: int, level: int, text: str, name: str) -> None:
        """Writes a line of the log, at once.

        Raises:
            OSError: it cannot be written; the file ends with what was before.
        """
        self._add(LOG_TOPIC, time_ns, foxglove.log(time_ns, level, text, name))
        self._writer.end_chunk()

    def finish(self) -> None:
        """Completes the file.

        Raises:
            OSError: there is no room for its index; it stays readable without.
        """
        self._writer.finish()

    def close(self) -> None:
        """Closes the file as it is."""
        self._writer.close()

    def _add_channels(self) -> None:
        kinds = {
            COLOR_TOPIC: CompressedImage,
            DEPTH_TOPIC: CompressedImage,
            CALIBRATION_TOPICS["color"]: CameraCalibration,
            CALIBRATION_TOPICS["depth"]: CameraCalibration,
            TRANSFORMS_TOPIC: FrameTransforms,
            LOG_TOPIC: Log,
            **{pose_topic(part.name): PoseInFrame for part in self._station.parts},
        }
        self._channels = {
            topic: self._writer.add_channel(
                topic, (named := foxglove.schema_of(kind))[0], "protobuf", named[1], "protobuf"
            )
            for topic, kind in kinds.items()
        }
        for topic, record, name in (
            (STATION_TOPIC, StationRecord, "snapfit.Station"),
            (RESULT_TOPIC, ResultRecord, "snapfit.Result"),
        ):
            schema = orjson.dumps(record.model_json_schema())
            self._channels[topic] = self._writer.add_channel(
                topic, name, "jsonschema", schema, "json"
            )

    def _write_station(self, time_ns: int) -> None:
        self._add(STATION_TOPIC, time_ns, self._station.model_dump_json().encode())
        self._calibrate("color", COLOR_FRAME, self._camera.color, time_ns)
        if self._camera.depth is not None:
            self._calibrate("depth", DEPTH_FRAME, self._camera.depth, time_ns)
            placed: dict[str, Pose] = {DEPTH_FRAME: self._camera.color_from_depth}
            self._add(TRANSFORMS_TOPIC, time_ns, foxglove.transforms(time_ns, COLOR_FRAME, placed))
        self._writer.end_chunk()

    def _calibrate(self, which: str, frame_id: str, camera: PinholeCamera, time_ns: int) -> None:
        message = foxglove.calibration(time_ns, frame_id, camera)
        self._add(CALIBRATION_TOPICS[which], time_ns, message)

    def _add_images(self, frame: Frame, time_ns: int, beside: Executor) -> None:
        kind = self._station.color_format
        depth = None if frame.depth is None else beside.submit(encode_png, frame.depth)
        color = encode_color(frame.color, kind)
        self._add(COLOR_TOPIC, time_ns, foxglove.image(time_ns, COLOR_FRAME, color, kind))
        if depth is not None:
            message = foxglove.image(time_ns, DEPTH_FRAME, depth.result(), "png")
            self._add(DEPTH_TOPIC, time_ns, message)

    def _add(self, topic: str, time_ns: int, data: bytes) -> None:
        self._writer.add(self._channels[topic], time_ns, data)
