"""The tracking methods by name: each a short composition of modalities and parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MappingProxyType

import numpy as np

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.parameters import TrackerParameters
from snapfit.tracking.tracker import Tracker

METHODS = MappingProxyType({"icg": TrackerParameters()})
"""`icg`: region and depth modality of every body by itself (Stoiber et al., ICG, CVPR 2022)."""

Progress = Callable[[str, float], None]


def create_tracker(
    method: str,
    parts: Sequence[Part],
    camera: RgbdCamera,
    progress: Progress | None = None,
    *,
    asset: Asset | None = None,
) -> Tracker:
    """A tracker that is ready for its first frame: models made or read, kernels compiled.

    Args:
        method: a name of `METHODS`.
        parts: what is to be tracked.
        camera: where the frames come from.
        progress: called with a message and the share that is done, 0 to 1.
        asset: what the parts belong to, for methods that know its assembly graph; None for loose
            parts.

    Raises:
        TrackingError: the method is unknown, or there is nothing to track.
        ViewpointModelError: a viewpoint model can neither be read nor made.
    """
    del asset  # No method knows the assembly graph yet.
    if method not in METHODS:
        known = ", ".join(METHODS)
        raise TrackingError(f"there is no method {method!r}; the methods are {known}")
    bodies = load_bodies(parts, progress)
    if progress is not None:
        progress("compiling the tracker's kernels", 0.0)
    warm_up(Tracker(bodies, camera, METHODS[method]))
    if progress is not None:
        progress("compiling the tracker's kernels", 1.0)
    return Tracker(bodies, camera, METHODS[method])


def warm_up(tracker: Tracker) -> None:
    """Run every kernel once on a blank frame, so that no real frame waits for the compiler."""
    camera = tracker.camera
    color = np.zeros((camera.color.height, camera.color.width, 3), dtype=np.uint8)
    depth = None
    if camera.depth is not None:
        depth = np.zeros((camera.depth.height, camera.depth.width), dtype=np.uint16)
    frame = Frame("warm-up", 0, color, depth)
    tracker.start(frame, {name: Pose.from_translation(0, 0, 0.7) for name in tracker.names})
    tracker.track(frame)
