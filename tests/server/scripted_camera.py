"""A live camera whose driver does what a file says: `SCRIPTED_CAMERA` names it.

fine | frozen | black | half | silent
"""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.camera import PinholeCamera
from snapfit.tracking.sources.driver import Images, LensedCamera
from snapfit.tracking.sources.live import LiveCamera

VARIABLE = "SCRIPTED_CAMERA"
_WIDTH, _HEIGHT = 320, 180
_PERIOD_S = 1 / 30


class ScriptedDriver:
    """Noise at 30 Hz, until it is told otherwise."""

    def __init__(self, orders: Path) -> None:
        self._orders = orders
        self._rng = np.random.default_rng(5)
        self._last = self._noise()

    def open(self) -> LensedCamera:
        camera = PinholeCamera(_WIDTH, _HEIGHT, 300, 300, 159.5, 89.5)
        return LensedCamera("Scripted", camera, 1 / _PERIOD_S)

    def read(self, timeout_s: float) -> Images | None:
        order = self._orders.read_text(encoding="ascii")
        if order == "silent":
            time.sleep(timeout_s)
            return None
        time.sleep(_PERIOD_S)
        if order == "frozen":
            return Images(self._last.copy())
        self._last = self._noise()
        if order == "black":
            return Images(self._last // 32)
        if order == "half":
            self._last[_HEIGHT // 2 :] = (0, 135, 0)
        return Images(self._last)

    def close(self) -> None:
        """Nothing to let go of."""

    def _noise(self) -> np.ndarray:
        return self._rng.integers(20, 230, (_HEIGHT, _WIDTH, 3), dtype=np.uint8)


def open_camera(asset: Asset) -> LiveCamera:
    """The camera, with the asset's parts."""
    return LiveCamera("scripted", ScriptedDriver(Path(os.environ[VARIABLE])), asset)
