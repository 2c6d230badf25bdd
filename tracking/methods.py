"""The tracking methods by name: each a short composition of modalities and parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from types import MappingProxyType

import numpy as np

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.body import load_bodies
from snapfit.tracking.camera_view import RigCamera
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.following import PAPER_GRAPH, GraphParameters
from snapfit.tracking.frame import Frame
from snapfit.tracking.method import (
    FRAME_BY_FRAME,
    REINITIALISED,
    FrameByFrameMethod,
    Method,
    MethodTracker,
    ReinitialisedMethod,
)
from snapfit.tracking.parameters import (
    NO_MOTION,
    ConfidenceParameters,
    LossParameters,
    MotionParameters,
    TrackerParameters,
)
from snapfit.tracking.tracker import Tracker

_ICG = TrackerParameters()
_CHECKED = replace(_ICG.occlusion, region_checking=True, held_threshold_m=0.01)
_GBOT = replace(
    _ICG,
    occlusion=_CHECKED,
    motion=MotionParameters(),
    loss=LossParameters(doubt=0.55),
    confidence=ConfidenceParameters(middle=0.73, steepness=25.0),
    regains=True,
)
_RIGID = GraphParameters(is_rigid=True)
_HASTY = GraphParameters(judge=AssemblyParameters(close_frames=1, near_frames=1, undone_frames=1))
_REINIT = ReinitialisedMethod(
    "gbot with network and shape beside: finds are tried out, and the likelier pose wins",
    _GBOT,
    GraphParameters(),
)
_BY_SHAPE = replace(
    _REINIT,
    summary="gbot with the geometric finder beside, which needs no training",
    detector="geometric",
)

METHODS: Mapping[str, Method] = MappingProxyType(
    {
        "srt3d": Method(
            "region modality alone (Stoiber et al., SRT3D, IJCV 2022)",
            replace(
                _ICG,
                depth=None,
                occlusion=replace(_ICG.occlusion, measured=False),
                confidence=ConfidenceParameters(middle=0.67, steepness=6.5, best=0.97),
            ),
        ),
        "icg": Method(
            "region and depth modality, every part by itself (Stoiber et al., ICG, 2022)"
        ),
        "icg+srt3d": Method(
            "icg, its pose refined by the region modality alone (Li et al., 2023)",
            replace(_ICG, refined_by_region=True),
        ),
        "mbicg": Method(
            "one structure of joints, told from outside (Stoiber et al., Mb-ICG, 2022)",
            _ICG,
            GraphParameters(is_told=True),
        ),
        "gbot-paper": Method(
            "the multi-state assembly graph as published: forward only, thresholds alone, rigid",
            _ICG,
            PAPER_GRAPH,
        ),
        "gbot": Method(
            "the multi-state assembly graph with joints, both ways, and a motion prior",
            _GBOT,
            GraphParameters(),
        ),
        "yolov8pose": FrameByFrameMethod(
            "YOLOv8-pose's keypoints and PnP in each frame by itself, colour alone (the paper's)"
        ),
        "yolov8pose-apart": FrameByFrameMethod(
            "yolov8pose, its network trained without images of joined parts",
            ablation_of="yolov8pose",
            variant="without-assembled",
        ),
        "yolov8pose+depth": FrameByFrameMethod(
            "yolov8pose with the distance fixed by measured depth",
            uses_depth=True,
        ),
        "gbot+reinit": _REINIT,
        "gbot+reinit-cold": replace(
            _REINIT, summary="gbot+reinit that is given no first pose", is_cold=True
        ),
        "gbot+reinit-geometric": _BY_SHAPE,
        "gbot+reinit-geometric-cold": replace(
            _BY_SHAPE, summary="gbot+reinit-geometric that is given no first pose", is_cold=True
        ),
        "gbot+reinit-paper": ReinitialisedMethod(
            "gbot-paper; every 10th frame, parts that yolov8pose finds more than 5 cm away are put "
            "there (the paper's)",
            _ICG,
            PAPER_GRAPH,
            uses_depth=False,
            is_published=True,
        ),
        "gbot-without-graph": Method("gbot, every part by itself", _GBOT, None, "gbot"),
        "gbot-without-region-checking": Method(
            "gbot, where the edge between like parts counts as a contour",
            replace(_GBOT, occlusion=_ICG.occlusion),
            GraphParameters(),
            "gbot",
        ),
        "gbot-without-hysteresis": Method(
            "gbot that switches at once, in both directions", _GBOT, _HASTY, "gbot"
        ),
        "gbot-rigid": Method("gbot with rigid links only", _GBOT, _RIGID, "gbot"),
        "gbot-without-motion": Method(
            "gbot without the motion prior",
            replace(_GBOT, motion=NO_MOTION),
            GraphParameters(),
            "gbot",
        ),
        "gbot-without-regain": Method(
            "gbot that does not look for lost parts",
            replace(_GBOT, regains=False),
            GraphParameters(),
            "gbot",
        ),
    }
)
"""The methods by name."""

Progress = Callable[[str, float], None]


def create_tracker(
    method: str,
    parts: Sequence[Part],
    camera: RgbdCamera,
    progress: Progress | None = None,
    *,
    asset: Asset | None = None,
    rig: Sequence[RigCamera] = (),
    frame_rate_hz: float = 30.0,
) -> MethodTracker:
    """A tracker that is ready for its first frame: models made or read, kernels compiled.

    Args:
        method: a name of `METHODS`.
        parts: what is to be tracked.
        camera: where the frames come from.
        progress: called with a message and the share that is done, 0 to 1.
        asset: what the parts belong to, for methods that know its assembly graph; None for loose
            parts.
        rig: further cameras that see the same bench.
        frame_rate_hz: of the frames; methods with a detector beside count its delay in frames.

    Raises:
        TrackingError: the method is unknown, there is nothing to track, or a detector cannot be
            used here.
        ViewpointModelError: a viewpoint model can neither be read nor made.
        DetectorError: a method that needs a network finds none, or one that does not fit.
    """
    if method not in METHODS:
        known = ", ".join(METHODS)
        raise TrackingError(f"there is no method {method!r}; the methods are {known}")
    chosen = METHODS[method]
    if isinstance(chosen, FrameByFrameMethod):
        return _frame_by_frame(method, chosen, parts, camera, asset)
    if isinstance(chosen, ReinitialisedMethod) and asset is None:
        raise TrackingError(f"{method} looks for the parts of an asset: name an asset")
    bodies = load_bodies(parts, progress)
    if progress is not None:
        progress("compiling the tracker's kernels", 0.0)
    make = partial(
        Tracker, bodies, camera, chosen.parameters, asset=asset, graph=chosen.graph, rig=rig
    )
    warm_up(make())
    if progress is not None:
        progress("compiling the tracker's kernels", 1.0)
    if isinstance(chosen, ReinitialisedMethod) and asset is not None:
        module = import_module(REINITIALISED)
        made: MethodTracker = module.reinitialised(make(), chosen, parts, asset, frame_rate_hz)
        return made
    return make()


def _frame_by_frame(
    name: str,
    method: FrameByFrameMethod,
    parts: Sequence[Part],
    camera: RgbdCamera,
    asset: Asset | None,
) -> MethodTracker:
    if asset is None:
        raise TrackingError(f"{name} needs the network in an asset's bundle: name an asset")
    module = import_module(FRAME_BY_FRAME)
    made: MethodTracker = module.open_frame_by_frame(
        asset.directory / method.variant, parts, camera, uses_depth=method.uses_depth
    )
    return made


def warm_up(tracker: Tracker) -> None:
    """Run every kernel once on a blank frame, so that no real frame waits for the compiler."""
    frames = [_blank_frame(camera) for camera in tracker.cameras]
    poses = {name: Pose.from_translation(0, 0, 0.7) for name in tracker.names}
    tracker.start(frames[0], poses, *frames[1:])
    tracker.track(*frames)


def _blank_frame(camera: RgbdCamera) -> Frame:
    color = np.zeros((camera.color.height, camera.color.width, 3), dtype=np.uint8)
    depth = None
    if camera.depth is not None:
        depth = np.zeros((camera.depth.height, camera.depth.width), dtype=np.uint16)
    return Frame("warm-up", 0, color, depth)
