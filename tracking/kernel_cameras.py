"""Cameras as the kernels take them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.tracking.kernels.types import Cameras


def kernel_cameras(camera: RgbdCamera) -> Cameras:
    """The two cameras; without a depth camera the colour camera stands in, and sees no depth."""
    return Cameras(
        color=_intrinsics(camera.color),
        depth=_intrinsics(camera.depth or camera.color),
        depth_unit=np.float32(camera.depth_scale_m),
        color_from_depth=np.array(camera.color_from_depth.matrix, dtype=np.float32),
        depth_from_color=np.array(camera.color_from_depth.inverse().matrix),
    )


def _intrinsics(camera: PinholeCamera) -> npt.NDArray[np.float32]:
    values = (camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)
    return np.array(values, dtype=np.float32)
