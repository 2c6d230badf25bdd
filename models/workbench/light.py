"""Lamps with their shadow maps, for what stands and for what moves; the lamp that goes around."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.workbench import kernels
from snapfit.models.workbench.scene import Lamp, Scene
from snapfit.models.workbench.shading import Bytes, LampCamera, Singles, kernel_lamps
from snapfit.models.workbench.split import FRAME_RATE_HZ

_STANDING_M, _MOVING_M = 0.85, 0.55
_ORBIT_M, _ORBIT_MIDDLE_M = 0.95, (0.0, 0.05, 0.0)
_TURN_DEG, _RISE_DEG = 1.7, 0.9
_LOW_DEG, _HIGH_DEG = 28.0, 78.0
_POINT_M = 0.035
_POINT_LIGHT = (1.00, 1.08, 1.12)
DIM_AMBIENT = np.array([[0.15, 0.145, 0.135], [0.05, 0.06, 0.07]])

PosedMesh = tuple[Mesh, Pose]


class Light:
    """Some lamps, each with one shadow map of what stands and one of what moves."""

    def __init__(self, scene: Scene, lamps: Sequence[Lamp], ambient: np.ndarray) -> None:
        self._standing = [LampCamera(lamp, scene, _STANDING_M) for lamp in lamps]
        self._moving = [LampCamera(lamp, scene, _MOVING_M) for lamp in lamps]
        size = self._standing[0].camera.height
        n = 2 * len(lamps)
        depth = np.zeros((n, size, size), dtype=np.float32)
        cast = np.zeros((n, size, size), dtype=np.uint8)
        views = [*self._standing, *self._moving]
        self._n = len(lamps)
        self._lamps = kernel_lamps(scene, lamps, ambient, views, depth, cast)

    def stand(self, bodies: Sequence[PosedMesh]) -> None:
        """Shadows of what stands (`world_from_body`); nothing moves."""
        for i, view in enumerate(self._standing):
            self._lamps.shadows[i], self._lamps.casts[i] = view.shadow(bodies)
        self._lamps.casts[self._n :] = 0

    def move(self, bodies: Sequence[PosedMesh]) -> None:
        """Shadows of what moves (`world_from_body`)."""
        for i, view in enumerate(self._moving, start=self._n):
            self._lamps.shadows[i], self._lamps.casts[i] = view.shadow(bodies)

    @property
    def lamps(self) -> kernels.Lamps:
        """As the kernels take them."""
        return self._lamps

    def keep(self) -> tuple[Singles, Bytes]:
        """What `stand` has made, to be put back."""
        return self._lamps.shadows[: self._n].copy(), self._lamps.casts[: self._n].copy()

    def put_back(self, kept: tuple[Singles, Bytes]) -> None:
        """In place of `stand`."""
        self._lamps.shadows[: self._n], self._lamps.casts[: self._n] = kept
        self._lamps.casts[self._n :] = 0


def moving_lamp(time_s: float, phase: float) -> Lamp:
    """A point light that goes around the bench on the upper half of a sphere.

    Args:
        time_s: of the script.
        phase: 0 to 1, where it starts.
    """
    frame = time_s * FRAME_RATE_HZ
    around = math.radians(_TURN_DEG * frame + 360 * phase)
    swing = 0.5 - 0.5 * math.cos(math.radians(_RISE_DEG * frame + 200 * phase))
    height = math.radians(_LOW_DEG + (_HIGH_DEG - _LOW_DEG) * swing)
    x, y, z = _ORBIT_MIDDLE_M
    place = (
        x + _ORBIT_M * math.cos(height) * math.cos(around),
        y + _ORBIT_M * math.cos(height) * math.sin(around),
        z + _ORBIT_M * math.sin(height),
    )
    return Lamp(place, _POINT_M, _POINT_LIGHT)
