"""From a clean picture and true depth to what a camera delivers: noise, edges, holes.

The depth model follows what is published of time-of-flight cameras such as the Azure Kinect: axial
noise that grows with the square of the distance, a bias of about a millimetre that changes slowly
over the picture, mixed pixels and gaps at depth edges, and a field of view narrower than colour's.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.workbench import sensor_kernels, texture

Bytes = npt.NDArray[np.uint8]
Singles = npt.NDArray[np.float32]

_NOISE_STEPS = 24.0
_READ_NOISE, _SHOT_NOISE = 1.1, 1.5
_EDGE_STEP_M = 0.012
_HOLE_SHARE, _FLYING_SHARE = 0.35, 0.3
_BIAS_M, _BIAS_SWING_M = 0.0006, 0.0005
_HALF_ANGLE_X_DEG, _CORNER_CUT = 37.5, 0.45
# Noise is drawn once, larger than the picture by this, and looked at in another place each frame.
_SHIFT_PX = 256


class Sensor:
    """An RGB-D camera whose depth is aligned with its colour, in millimetres."""

    def __init__(self, camera: PinholeCamera, rng: np.random.Generator) -> None:
        shape = (camera.height + _SHIFT_PX, camera.width + _SHIFT_PX)
        grain = rng.standard_normal((*shape, 3), dtype=np.float32)
        # A colour camera interpolates its channels: neighbours share some of their noise.
        grain = cv2.GaussianBlur(grain, (3, 3), 0.55)
        grain = grain / grain.std() * _NOISE_STEPS
        self._color_noise = np.clip(np.rint(grain), -127, 127).astype(np.int8)
        self._depth_noise = rng.standard_normal(shape, dtype=np.float32)
        self._chance = rng.random(shape, dtype=np.float32)
        size = (camera.height, camera.width)
        swing = texture.smooth_noise(rng, size, (camera.height / 3, camera.width / 4))
        self._bias = (_BIAS_M + _BIAS_SWING_M * swing).astype(np.float32)
        brightness = np.linspace(0, 1, 256)
        gain = (
            _READ_NOISE + _SHOT_NOISE * np.sqrt(brightness) * (1 - 0.5 * brightness)
        ) / _NOISE_STEPS
        self._gain = gain.astype(np.float32)
        self._seen = _field_of_view(camera)

    def color(self, clean: Bytes, rng: np.random.Generator) -> Bytes:
        """A picture (H, W, 3) with noise."""
        noise = self._color_noise[self._shifted(clean.shape[:2], rng)]
        noisy: Bytes = sensor_kernels.noisy_color(clean, noise, self._gain)
        return noisy

    def depth(self, true_m: Singles, rng: np.random.Generator) -> npt.NDArray[np.uint16]:
        """Measured depth (H, W) in millimetres, 0 where there is none, of true depth (H, W), m."""
        around = np.ones((3, 3), dtype=np.uint8)
        measured: npt.NDArray[np.uint16] = sensor_kernels.noisy_depth(
            true_m,
            cv2.erode(true_m, around),
            cv2.dilate(true_m, around),
            self._bias,
            self._depth_noise[self._shifted(true_m.shape, rng)],
            self._chance[self._shifted(true_m.shape, rng)],
            self._seen,
            _EDGE_STEP_M,
            _HOLE_SHARE,
            _FLYING_SHARE,
        )
        return measured

    def _shifted(self, shape: tuple[int, ...], rng: np.random.Generator) -> tuple[slice, slice]:
        row, column = rng.integers(0, _SHIFT_PX, 2)
        return slice(row, row + shape[0]), slice(column, column + shape[1])


def _field_of_view(camera: PinholeCamera) -> npt.NDArray[np.bool_]:
    """(H, W) whether depth is measured: a hexagon, narrower than the picture."""
    half_width = camera.fx * np.tan(np.radians(_HALF_ANGLE_X_DEG))
    columns = np.abs(np.arange(camera.width) - camera.cx)[None, :]
    rows = np.abs(np.arange(camera.height) - camera.cy)[:, None]
    inside: npt.NDArray[np.bool_] = columns + _CORNER_CUT * rows < half_width
    return inside
