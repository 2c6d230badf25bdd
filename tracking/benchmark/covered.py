"""A camera that sees nothing for a while: a hand on its lens, or one held close before it."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from snapfit.tracking.frame import Frame

_NOISE = 4.0
_HAND_BGR = (38.0, 52.0, 78.0)
_HAND_M, _HAND_NOISE_M = 0.2, 0.002


class Cover(StrEnum):
    """What covers the camera.

    LENS: black, and no depth: nearer than any depth camera measures.
    HAND: the colour of a hand in its own shadow, 20 cm before the camera.
    """

    LENS = "lens"
    HAND = "hand"


def covered(frame: Frame, cover: Cover, depth_scale_m: float, rng: np.random.Generator) -> Frame:
    """What a covered camera sees in the place of a frame.

    Args:
        frame: whose name, time and size are kept.
        cover: what is before the camera.
        depth_scale_m: of a count of the depth image.
        rng: of the noise.
    """
    color = np.array((0.0, 0.0, 0.0) if cover is Cover.LENS else _HAND_BGR)
    noisy = color + rng.normal(0.0, _NOISE, frame.color.shape)
    depth = None if frame.depth is None else _depth(frame.depth, cover, depth_scale_m, rng)
    return replace(frame, color=np.clip(noisy, 0, 255).astype(np.uint8), depth=depth)


def _depth(
    depth: npt.NDArray[np.uint16], cover: Cover, depth_scale_m: float, rng: np.random.Generator
) -> npt.NDArray[np.uint16]:
    if cover is Cover.LENS:
        return np.zeros_like(depth)
    measured_m = _HAND_M + rng.normal(0.0, _HAND_NOISE_M, depth.shape)
    return np.rint(measured_m / depth_scale_m).astype(np.uint16)
