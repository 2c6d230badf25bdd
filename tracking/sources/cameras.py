"""Opens the camera at an address."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.asset import Asset
from snapfit.models.camera_file import read_camera_file
from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraDriver
from snapfit.tracking.sources.live import LiveCamera

_UNCALIBRATED = ("uvc", "rtsp")


def open_camera(
    address: Address, asset: Asset | None = None, calibration: Path | None = None
) -> LiveCamera:
    """Connects to a camera.

    Args:
        address: where it is.
        asset: with the parts that are to be tracked.
        calibration: camera file of a camera that brings no calibration.

    Raises:
        SourceError: there is no such camera, its library is not installed, or a calibration is
            missing or too much.
        CameraError: the camera file is refused.
    """
    return LiveCamera(address.text, _driver(address, calibration), asset)


def _driver(address: Address, calibration: Path | None) -> CameraDriver:
    if address.kind in _UNCALIBRATED:
        if calibration is None:
            raise SourceError(
                f"{address.text}: this camera brings no calibration: make one with "
                "snapfit calibrate, and name the file (station.calibration)"
            )
        from snapfit.tracking.sources.video import VideoCamera

        return VideoCamera(address, read_camera_file(calibration))
    if calibration is not None:
        raise SourceError(
            f"{address.text}: this camera brings its own calibration: leave out station.calibration"
        )
    return _calibrated(address)


def _calibrated(address: Address) -> CameraDriver:
    """Each kind's module is imported when it is asked for, and its library then."""
    if address.kind == "realsense":
        from snapfit.tracking.sources.realsense import RealSense

        return RealSense(address)
    if address.kind == "kinect":
        from snapfit.tracking.sources.azure_kinect import AzureKinect

        return AzureKinect(address)
    if address.kind == "orbbec":
        from snapfit.tracking.sources.orbbec import Orbbec

        return Orbbec(address)
    from snapfit.tracking.sources.oak import Oak

    return Oak(address)
