"""Foxglove's types, filled from ours: any viewer of MCAP files shows a recording.

Schemas: https://docs.foxglove.dev/docs/sdk/schemas. In their optical frames, as in ours, z goes
forward.
"""

from __future__ import annotations

from typing import Any

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Pose_pb2 import Pose as PoseMessage
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.timestamp_pb2 import Timestamp

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose

Message = Any

# Foxglove's levels, from Python's.
_LEVELS = ((50, Log.FATAL), (40, Log.ERROR), (30, Log.WARNING), (20, Log.INFO), (0, Log.DEBUG))


def schema_of(kind: type[Message]) -> tuple[str, bytes]:
    """The name of a type and what describes it and all that it is made of."""
    files = FileDescriptorSet()
    seen: set[str] = set()

    def add(file: Any) -> None:
        if file.name in seen:
            return
        seen.add(file.name)
        for dependency in file.dependencies:
            add(dependency)
        file.CopyToProto(files.file.add())

    add(kind.DESCRIPTOR.file)
    return str(kind.DESCRIPTOR.full_name), bytes(files.SerializeToString())


def stamp(time_ns: int) -> Timestamp:
    """Unix time, ns, as Foxglove's types have it."""
    return Timestamp(seconds=time_ns // 10**9, nanos=time_ns % 10**9)


def image(time_ns: int, frame_id: str, encoded: bytes, kind: str) -> bytes:
    """A compressed image; `kind`: png or jpeg."""
    message = CompressedImage(
        timestamp=stamp(time_ns), frame_id=frame_id, data=encoded, format=kind
    )
    return bytes(message.SerializeToString())


def image_data(message: bytes) -> bytes:
    """The encoded image in a message."""
    return bytes(CompressedImage.FromString(message).data)


def calibration(time_ns: int, frame_id: str, camera: PinholeCamera) -> bytes:
    """An undistorted camera."""
    k = camera.matrix
    message = CameraCalibration(
        timestamp=stamp(time_ns),
        frame_id=frame_id,
        width=camera.width,
        height=camera.height,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=k.ravel().tolist(),
        R=[1.0, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[k[0, 0], 0, k[0, 2], 0, 0, k[1, 1], k[1, 2], 0, 0, 0, 1, 0],
    )
    return bytes(message.SerializeToString())


def pose_in_frame(time_ns: int, frame_id: str, pose: Pose) -> bytes:
    """A pose, given in the frame of that name."""
    placed = PoseMessage(position=_vector(pose), orientation=_quaternion(pose))
    message = PoseInFrame(timestamp=stamp(time_ns), frame_id=frame_id, pose=placed)
    return bytes(message.SerializeToString())


def transforms(time_ns: int, parent: str, children: dict[str, Pose]) -> bytes:
    """Where frames stand in their parent."""
    message = FrameTransforms(
        transforms=[
            FrameTransform(
                timestamp=stamp(time_ns),
                parent_frame_id=parent,
                child_frame_id=name,
                translation=_vector(pose),
                rotation=_quaternion(pose),
            )
            for name, pose in children.items()
        ]
    )
    return bytes(message.SerializeToString())


def log(time_ns: int, level: int, text: str, name: str) -> bytes:
    """A line of the log; `level` is Python's."""
    severity = next(kind for least, kind in _LEVELS if level >= least)
    message = Log(timestamp=stamp(time_ns), level=severity, message=text, name=name)
    return bytes(message.SerializeToString())


def log_text(message: bytes) -> str:
    """The text of a line of the log."""
    return str(Log.FromString(message).message)


def _vector(pose: Pose) -> Vector3:
    x, y, z = pose.translation.tolist()
    return Vector3(x=x, y=y, z=z)


def _quaternion(pose: Pose) -> Quaternion:
    x, y, z, w = pose.quaternion.tolist()
    return Quaternion(x=x, y=y, z=z, w=w)
