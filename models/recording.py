"""Recorded RGB-D frames in whatever folder layout: what is known before the first is decoded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose


@dataclass(frozen=True)
class FrameFiles:
    """Where one frame lies on disk.

    Attributes:
        name: the frame's name in its recording.
        color: image file, 8 bits a channel.
        depth: image file, 16 bits; None where the recording has no depth.
    """

    name: str
    color: Path
    depth: Path | None = None


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """What is true in one frame.

    Attributes:
        frame: the frame's name.
        camera_from_body: true pose of each part, colour camera's frame.
        visibility: share of each part's silhouette that is seen, 0 to 1; empty where unknown.
        state: the assembly state, None where unknown.
    """

    frame: str
    camera_from_body: Mapping[str, Pose]
    visibility: Mapping[str, float] = field(default_factory=dict)
    state: str | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording that can be played.

    Attributes:
        name: shown to people.
        directory: where it lies.
        camera: colour camera, and depth camera if there is one.
        frame_rate_hz: frames a second.
        frames: in the order of their exposure.
        parts: the parts to be tracked.
        initial_poses: `camera_from_body` of parts in the first frame.
        asset: the asset under assembly, None where the recording brings loose parts.
        truth: by frame name; empty where nothing is known.
    """

    name: str
    directory: Path
    camera: RgbdCamera
    frame_rate_hz: float
    frames: tuple[FrameFiles, ...]
    parts: tuple[Part, ...]
    initial_poses: Mapping[str, Pose]
    asset: Asset | None = None
    truth: Mapping[str, GroundTruth] = field(default_factory=dict)
