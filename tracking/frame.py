"""One RGB-D frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError, TrackingError


@dataclass(frozen=True, eq=False)
class Frame:
    """What a camera delivers at one instant.

    Attributes:
        name: the frame's name in its sequence ("000200"), or its number.
        captured_at_ns: time of exposure, integer nanoseconds of Unix time.
        color: (H, W, 3) uint8, BGR (OpenCV's order), C-contiguous.
        depth: (H, W) uint16 in units of the camera's `depth_scale_m`, 0 and 65535 mean no depth;
            None where the source has no depth camera.
        world_from_camera: where the colour camera is; the identity at a fixed bench.
    """

    name: str
    captured_at_ns: int
    color: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16] | None = None
    world_from_camera: Pose = field(default_factory=Pose.identity)


def check_frame(frame: Frame, camera: RgbdCamera) -> None:
    """Make sure that a frame's images are what the camera delivers.

    Raises:
        FrameError: size or type of an image differ.
    """
    color = camera.color
    _check_image(frame.name, "colour", frame.color, (color.height, color.width, 3), np.uint8)
    if camera.depth is not None and frame.depth is not None:
        size = _size(camera.depth)
        _check_image(frame.name, "depth", frame.depth, size, np.uint16)


def fitting_frames(
    frames: Sequence[Frame | None], cameras: Sequence[RgbdCamera]
) -> tuple[tuple[Frame | None, ...], tuple[FrameError, ...]]:
    """A frame or None for each camera, and what is wrong with those that fit no camera.

    Args:
        frames: in the order of the cameras; the last ones may be missing.
        cameras: one or several.

    Raises:
        FrameError: no frame fits its camera.
        TrackingError: there is no frame, or there are more frames than cameras.
    """
    if len(frames) > len(cameras):
        raise TrackingError(f"there are {len(frames)} frames for {len(cameras)} camera(s)")
    fitting: list[Frame | None] = [None] * len(cameras)
    errors = []
    for i, frame in enumerate(frames):
        if frame is None:
            continue
        try:
            check_frame(frame, cameras[i])
            fitting[i] = frame
        except FrameError as error:
            errors.append(error)
    if not any(fitting):
        if errors:
            raise errors[0]
        raise TrackingError("no camera has a frame: give at least one")
    return tuple(fitting), tuple(errors)


def _size(camera: PinholeCamera) -> tuple[int, int]:
    return camera.height, camera.width


def _check_image(
    name: str, which: str, image: npt.NDArray[Any], shape: tuple[int, ...], dtype: type
) -> None:
    if image.shape != shape or image.dtype != dtype:
        raise FrameError(
            name,
            f"the {which} image is {image.shape} {image.dtype}, "
            f"the camera's is {shape} {np.dtype(dtype)}",
        )
