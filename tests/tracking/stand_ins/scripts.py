"""What a camera of a stand-in does, frame by frame; the drivers' stand-ins ask for it."""

from __future__ import annotations

import time

import numpy as np

WIDTH, HEIGHT = 64, 48


class Script:
    """Attributes that the tests set while a source reads.

    Attributes:
        is_there: whether the camera can be opened, and goes on.
        is_silent: it delivers nothing, and says nothing of it.
        serial: of the camera that is there.
        opened, closed: how often.
        color, depth: the next images; noise if None.
        wants_depth: whether there is a depth image.
    """

    def __init__(self) -> None:
        self.is_there, self.is_silent = True, False
        self.serial = "0815"
        self.opened = self.closed = 0
        self.color: np.ndarray | None = None
        self.depth: np.ndarray | None = None
        self.size, self.depth_size = (WIDTH, HEIGHT), (32, 24)
        self.focal_px = 60.0
        self._rng = np.random.default_rng(3)

    def next_color(self) -> np.ndarray:
        """(H, W, 3) uint8, BGR; a little later, as a camera does."""
        time.sleep(0.005)
        if self.color is not None:
            return self.color
        width, height = self.size
        return self._rng.integers(20, 230, (height, width, 3)).astype(np.uint8)

    def next_depth(self) -> np.ndarray:
        """(H, W) uint16."""
        if self.depth is not None:
            return self.depth
        width, height = self.depth_size
        return self._rng.integers(400, 900, (height, width)).astype(np.uint16)

    def wait(self, timeout_ms: float) -> bool:
        """Whether a frame comes in time."""
        if self.is_silent:
            time.sleep(timeout_ms / 1000.0)
        return not self.is_silent
