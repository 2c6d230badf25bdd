"""What every source of frames can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

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


@runtime_checkable
class LiveSource(Protocol):
    """A source that sets the pace: its frames come when the camera has them.

    `read` waits for the next one, less than a second, and its `captured_at_ns` is monotonic time
    (`time.monotonic_ns`), which all processes of a machine share.
    """

    @property
    def is_live(self) -> bool:
        """Whether it is a camera."""


def is_live(source: Source) -> bool:
    """Whether a source's frames come when the camera has them; recordings wait to be read."""
    return isinstance(source, LiveSource) and source.is_live
