"""One RGB-D frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose


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
