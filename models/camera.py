"""Pinhole cameras. Frame: OpenCV (x right, y down, z forward); pixel centres at integers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from snapfit.models.errors import CameraError
from snapfit.models.pose import Pose


@dataclass(frozen=True)
class PinholeCamera:
    """An undistorted camera.

    Attributes:
        width, height: image size, px.
        fx, fy: focal lengths, px.
        cx, cy: principal point, px (pixel centres at integers).

    Raises:
        CameraError: a size or focal length that is not positive, or a value that is not finite.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        for name in ("width", "height", "fx", "fy"):
            value = getattr(self, name)
            if not math.isfinite(value) or value <= 0:
                raise CameraError(f"the camera's {name} is {value}: it must be a positive number")
        for name in ("cx", "cy"):
            if not math.isfinite(getattr(self, name)):
                raise CameraError(f"the camera's {name} is {getattr(self, name)}: must be finite")

    @property
    def matrix(self) -> npt.NDArray[np.float64]:
        """(3, 3) intrinsic matrix K."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], dtype=np.float64)

    def project(self, points: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
        """Points (..., 3) in the camera frame, metres, z > 0, to pixels (..., 2)."""
        z = points[..., 2]
        u = self.fx * points[..., 0] / z + self.cx
        v = self.fy * points[..., 1] / z + self.cy
        return np.stack([u, v], axis=-1)

    def scaled(self, factor: float) -> PinholeCamera:
        """The same camera with an image of `factor` times the size (rounded to whole pixels)."""
        width, height = round(self.width * factor), round(self.height * factor)
        sx, sy = width / self.width, height / self.height
        return PinholeCamera(
            width=width,
            height=height,
            fx=self.fx * sx,
            fy=self.fy * sy,
            cx=(self.cx + 0.5) * sx - 0.5,
            cy=(self.cy + 0.5) * sy - 0.5,
        )


@dataclass(frozen=True)
class RgbdCamera:
    """A colour camera and, beside it, perhaps a depth camera with its own intrinsics and place.

    Attributes:
        color: the colour camera; poses of bodies are given in its frame.
        depth: the depth camera, None for colour alone.
        depth_scale_m: metres per unit of the 16-bit depth image (0 and 65535 mean no depth).
        color_from_depth: maps points of the depth camera's frame into the colour camera's.
    """

    color: PinholeCamera
    depth: PinholeCamera | None = None
    depth_scale_m: float = 0.001
    color_from_depth: Pose = field(default_factory=Pose.identity)

    def __post_init__(self) -> None:
        if not math.isfinite(self.depth_scale_m) or self.depth_scale_m <= 0:
            raise CameraError(f"depth_scale_m is {self.depth_scale_m}: must be a positive number")


AZURE_KINECT_720P = PinholeCamera(1280, 720, fx=607.2, fy=607.2, cx=639.2, cy=364.8)
