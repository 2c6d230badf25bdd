"""What all answers are made of."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix4 = tuple[Quaternion, Quaternion, Quaternion, Quaternion]
Covariance = Annotated[tuple[float, ...], Field(min_length=36, max_length=36)]


class Schema(BaseModel):
    """Base of all answers: frozen; what a newer server says beside is ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class Convention(StrEnum):
    """Along which axes an answer is given: docs/conventions.md."""

    OPENCV = "opencv"
    OPENXR = "openxr"
    UNITY = "unity"
    ROS = "ros"
    ROS_OPTICAL = "ros_optical"


class PlacedPose(Schema):
    """A position (metres) and an orientation (unit quaternion x, y, z, w)."""

    position: Vector3
    orientation: Quaternion

    def matrix(self) -> Matrix4:
        """4x4, row-major: maps points of the posed thing into the frame of the answer."""
        return pose_matrix(self.position, self.orientation)


def pose_matrix(position: Vector3, orientation: Quaternion) -> Matrix4:
    """The 4x4 matrix, row-major, of a position (metres) and a unit quaternion x, y, z, w."""
    x, y, z, w = orientation
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), position[0]),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), position[1]),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), position[2]),
        (0.0, 0.0, 0.0, 1.0),
    )
