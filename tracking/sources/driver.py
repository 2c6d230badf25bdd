"""What a camera's driver has to do: connect, deliver images, let go. One file for each library."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import SourceError


class CameraLostError(SourceError):
    """The camera is not there, or is there no more: it may come back."""


@dataclass(frozen=True, eq=False)
class LensedCamera:
    """A camera as its maker describes it, its lens included.

    Attributes:
        name: model and serial number, shown to people.
        color: intrinsics of the colour camera.
        frame_rate_hz: frames a second.
        color_distortion: coefficients in OpenCV's order; empty where there is nothing to undo.
        depth: intrinsics of the depth camera; None for colour alone.
        depth_distortion: as of colour.
        depth_scale_m: metres of one unit of the depth image.
        color_from_depth: from the depth camera's frame into the colour camera's.
    """

    name: str
    color: PinholeCamera
    frame_rate_hz: float
    color_distortion: tuple[float, ...] = ()
    depth: PinholeCamera | None = None
    depth_distortion: tuple[float, ...] = ()
    depth_scale_m: float = 0.001
    color_from_depth: Pose = field(default_factory=Pose.identity)

    @property
    def undistorted(self) -> RgbdCamera:
        """The camera once its distortion is undone."""
        return RgbdCamera(self.color, self.depth, self.depth_scale_m, self.color_from_depth)

    def is_like(self, other: LensedCamera) -> bool:
        """Whether images of both can take each other's place."""
        mine, others = (
            (c.color, c.color_distortion, c.depth, c.depth_distortion, c.depth_scale_m)
            for c in (self, other)
        )
        places = self.color_from_depth.matrix, other.color_from_depth.matrix
        return mine == others and bool(np.allclose(*places, atol=1e-6))


@dataclass(frozen=True, eq=False)
class Images:
    """What a camera delivers at one instant, its distortion still in it.

    Attributes:
        color: (H, W, 3) uint8, BGR.
        depth: (H, W) uint16; None where there is none this time.
    """

    color: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16] | None = None


class CameraDriver(Protocol):
    """A camera of one kind; used from one thread at a time."""

    def open(self) -> LensedCamera:
        """Connects and begins to stream.

        Raises:
            CameraLostError: there is no such camera, or it is in use.
            SourceError: it cannot be used, for good.
        """

    def read(self, timeout_s: float) -> Images | None:
        """The next images, None if none come in time.

        Raises:
            CameraLostError: it is gone.
        """

    def close(self) -> None:
        """Lets go of the camera; may be called twice, or before `open`."""


def load_driver(module: str, extra: str, package: str) -> Any:
    """A driver's library.

    Args:
        module: to import.
        extra: of snapfit, that brings it.
        package: that it is in.

    Raises:
        SourceError: it is not installed, or cannot be loaded.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as error:
        raise SourceError(
            f"this camera needs the package {package} ({error}): pip install 'snapfit[{extra}]'"
        ) from error
