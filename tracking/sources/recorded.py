"""Plays a recording: frames are decoded ahead of time, on a thread of their own."""

from __future__ import annotations

import itertools
import time
from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Literal

from snapfit.models.asset import Asset, Part
from snapfit.models.bop import CAMERA_NAME, load_bop_scene
from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import SequenceError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth, Recording
from snapfit.models.sequence import SEQUENCE_NAME, load_sequence
from snapfit.tracking.frame import Frame
from snapfit.tracking.sources.images import read_frame

Loop = Literal["no", "restart", "pingpong"]
LOOPS: tuple[Loop, ...] = ("no", "restart", "pingpong")

_N_AHEAD = 4


class RecordedSource:
    """A recording as a source of frames; see `Source`.

    Exposure times begin when the source is opened and go up by one frame's time, whatever the
    loop: they are as strictly increasing as a camera's.
    """

    def __init__(
        self,
        recording: Recording | Path | str,
        loop: Loop = "no",
        *,
        start_at_ns: int | None = None,
    ) -> None:
        """Opens a recording.

        Args:
            recording: one that is loaded, or its folder.
            loop: after the last frame: "no", end; "restart", the first again (a jump);
                "pingpong", backwards to the first and forwards again (no jump).
            start_at_ns: exposure of the first frame, Unix time; now, if None.

        Raises:
            SequenceError: as `load_recording`.
        """
        if not isinstance(recording, Recording):
            recording = load_recording(Path(recording))
        self.recording = recording
        self._start_at_ns = time.time_ns() if start_at_ns is None else start_at_ns
        self._order = enumerate(_order(len(recording.frames), loop))
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="snapfit-decode")
        self._ahead: deque[Future[Frame]] = deque()
        self._closed = False

    @property
    def name(self) -> str:
        """The recording's name."""
        return self.recording.name

    @property
    def camera(self) -> RgbdCamera:
        """The camera of every frame."""
        return self.recording.camera

    @property
    def frame_rate_hz(self) -> float:
        """Frames a second."""
        return self.recording.frame_rate_hz

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts to be tracked."""
        return self.recording.parts

    @property
    def asset(self) -> Asset | None:
        """The asset under assembly, None for loose parts."""
        return self.recording.asset

    @property
    def initial_poses(self) -> Mapping[str, Pose]:
        """`camera_from_body` of parts in the first frame."""
        return self.recording.initial_poses

    @property
    def truth(self) -> Mapping[str, GroundTruth]:
        """What is true, by frame name; empty where nothing is known."""
        return self.recording.truth

    def read(self) -> Frame | None:
        """The next frame, None at the end or once closed.

        Raises:
            FrameError: this one frame cannot be used; the next call goes on after it.
        """
        if self._closed:
            return None
        while len(self._ahead) < _N_AHEAD and (following := next(self._order, None)):
            self._ahead.append(self._executor.submit(self._decode, *following))
        return self._ahead.popleft().result() if self._ahead else None

    def close(self) -> None:
        """Ends the decoding thread; may be called twice."""
        self._closed = True
        self._ahead.clear()
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _decode(self, number: int, index: int) -> Frame:
        captured_at_ns = self._start_at_ns + round(number * 1e9 / self.frame_rate_hz)
        return read_frame(self.recording.frames[index], self.camera, captured_at_ns)


def load_recording(path: Path, asset: Asset | None = None) -> Recording:
    """Loads a recorded sequence or a BOP scene, whichever lies there.

    Raises:
        SequenceError: neither, or a broken one.
        ManifestError: the asset that a sequence names is refused.
        MeshError: a mesh is refused.
    """
    if path.name in (SEQUENCE_NAME, CAMERA_NAME):
        path = path.parent
    if not path.is_dir():
        raise SequenceError(path, "no such folder")
    if (path / SEQUENCE_NAME).is_file():
        return load_sequence(path, asset)
    if (path / CAMERA_NAME).is_file():
        return load_bop_scene(path, asset)
    problem = f"neither {SEQUENCE_NAME} (a sequence) nor {CAMERA_NAME} (a BOP scene) is in here"
    raise SequenceError(path, problem)


def _order(n_frames: int, loop: Loop) -> Iterator[int]:
    forwards = range(n_frames)
    if loop == "no":
        return iter(forwards)
    backwards = range(n_frames - 2, 0, -1) if loop == "pingpong" else range(0)
    return itertools.cycle([*forwards, *backwards])
