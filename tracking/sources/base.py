"""What every source of frames can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame


class Source(Protocol):
    """A stream of RGB-D frames, and what is known of the scene before the first."""

    @property
    def name(self) -> str:
        """Shown to people."""

    @property
    def camera(self) -> RgbdCamera:
        """The camera of every frame."""

    @property
    def frame_rate_hz(self) -> float:
        """Frames a second."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts to be tracked."""

    @property
    def asset(self) -> Asset | None:
        """The asset under assembly, None for loose parts."""

    @property
    def initial_poses(self) -> Mapping[str, Pose]:
        """`camera_from_body` of parts in the first frame."""

    def read(self) -> Frame | None:
        """The next frame, None at the end.

        Raises:
            FrameError: this one frame cannot be used; the next call goes on after it.
        """

    def close(self) -> None:
        """Lets go of files, threads and devices; may be called twice."""
