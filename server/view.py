"""How a client wants poses: in which frame, in which convention."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from snapfit.server import quaternion
from snapfit.server.conventions import AXES, Convention
from snapfit.server.rigid import Rigid

CAMERA = "camera"


@dataclass(frozen=True)
class View:
    """The frame and the convention of an answer.

    Attributes:
        convention: axes and handedness.
        frame: its name in the answer.
        frame_from_camera: where the camera is in that frame, in OpenCV's axes; None: the frame is
            the camera's.
        revision: changes whenever `frame_from_camera` does.
    """

    convention: Convention = Convention.OPENCV
    frame: str = CAMERA
    frame_from_camera: Rigid | None = None
    revision: int = 0

    @property
    def tag(self) -> str:
        """What tells its answers from others', for entity tags; empty for the plain view."""
        if self.frame_from_camera is None:
            return "" if self.convention is Convention.OPENCV else f"-{self.convention}"
        return f"-{self.convention}-{self.frame}.{self.revision}"

    def part(self, part: dict[str, Any]) -> dict[str, Any]:
        """JSON of a `PartPose` in the camera frame, in this view."""
        if not self.tag or part["position"] is None or part["orientation"] is None:
            return part
        pose = self.pose(Rigid(part["position"], part["orientation"]))
        linear, angular = part["linear_velocity"], part["angular_velocity"]
        covariance = part["covariance"]  # of the body frame: the other frame's place is no matter
        if self.frame_from_camera is not None:
            turn = self.frame_from_camera.orientation
            linear = None if linear is None else quaternion.rotate(turn, linear)
            angular = None if angular is None else quaternion.rotate(turn, angular)
        axes = AXES[self.convention]
        return {
            **part,
            "position": pose.position,
            "orientation": pose.orientation,
            "covariance": None if covariance is None else axes.covariance(covariance),
            "linear_velocity": None if linear is None else axes.vector(linear),
            "angular_velocity": None if angular is None else axes.axial(angular),
        }

    def pose(self, camera_from_body: Rigid) -> Rigid:
        """A pose in the camera frame and OpenCV's axes, in this view."""
        pose = camera_from_body
        if self.frame_from_camera is not None:
            pose = self.frame_from_camera @ pose
        return pose.along(AXES[self.convention])


PLAIN = View()
"""What the worker writes: the camera frame in OpenCV's axes."""
