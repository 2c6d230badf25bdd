"""Luxonis OAK-D by depthai, version 3: depth in the colour camera's view, made on the camera."""

from __future__ import annotations

import datetime
from contextlib import suppress
from typing import Any

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraLostError, Images, LensedCamera, load_driver


class Oak:
    """A `CameraDriver`; the first camera that is found, or the one with an id or address."""

    def __init__(self, address: Address) -> None:
        """Loads the library.

        Raises:
            SourceError: it is not installed.
        """
        self._dai = load_driver("depthai", "oak", "depthai")
        self._address = address
        self._pipeline: Any = None
        self._queue: Any = None

    def open(self) -> LensedCamera:
        """As in `CameraDriver`."""
        dai, address = self._dai, self._address
        size = (address.width or 1280, address.height or 720)
        fps = float(address.fps or 30)
        try:
            where = address.where
            device = dai.Device(dai.DeviceInfo(where)) if where else dai.Device()
            self._pipeline = dai.Pipeline(device)
            self._queue = self._built(self._pipeline, size, fps)
            self._pipeline.start()
            k = device.readCalibration().getCameraIntrinsics(dai.CameraBoardSocket.CAM_A, *size)
            name = f"OAK {device.getDeviceId()}"
        except RuntimeError as error:
            raise CameraLostError(f"no OAK {address.where} that can do this: {error}") from error
        camera = PinholeCamera(*size, k[0][0], k[1][1], k[0][2], k[1][2])
        # The camera undoes its distortion itself, and puts depth into the same view.
        return LensedCamera(name, camera, fps, depth=camera, depth_scale_m=0.001)

    def read(self, timeout_s: float) -> Images | None:
        """As in `CameraDriver`."""
        try:
            group = self._queue.get(datetime.timedelta(seconds=timeout_s))
        except RuntimeError as error:  # a closed queue's QueueException is one
            raise CameraLostError(str(error)) from error
        if group is None:
            return None
        color = np.array(group["color"].getCvFrame(), dtype=np.uint8)
        return Images(color, np.array(group["depth"].getFrame(), dtype=np.uint16))

    def close(self) -> None:
        """As in `CameraDriver`."""
        pipeline, self._pipeline, self._queue = self._pipeline, None, None
        if pipeline is not None:
            with suppress(RuntimeError):  # a camera that is gone cannot be stopped
                pipeline.stop()

    def _built(self, pipeline: Any, size: tuple[int, int], fps: float) -> Any:
        """The queue of pairs of images that belong together."""
        dai = self._dai
        sockets, nodes = dai.CameraBoardSocket, dai.node
        center = pipeline.create(nodes.Camera).build(sockets.CAM_A)
        color = center.requestOutput(
            size, dai.ImgFrame.Type.BGR888i, fps=fps, enableUndistortion=True
        )
        pair = [
            pipeline.create(nodes.Camera).build(socket).requestOutput((640, 400), fps=fps)
            for socket in (sockets.CAM_B, sockets.CAM_C)
        ]
        stereo = pipeline.create(nodes.StereoDepth).build(*pair)
        stereo.setLeftRightCheck(True)
        stereo.setSubpixel(True)
        stereo.setDepthAlign(sockets.CAM_A)
        stereo.setOutputSize(*size)
        together = pipeline.create(nodes.Sync)
        color.link(together.inputs["color"])
        stereo.depth.link(together.inputs["depth"])
        return together.out.createOutputQueue(maxSize=1, blocking=False)
