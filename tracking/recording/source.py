"""Plays a station's recording as a source of frames."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.asset import Asset
from snapfit.models.recording import FrameFiles, Recording
from snapfit.tracking.errors import RecordingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.records import pose_of
from snapfit.tracking.sources.recorded import Loop, RecordedSource


class McapSource(RecordedSource):
    """The frames of a recording whose images are there; see `Source`.

    Attributes:
        opened: the file.
    """

    def __init__(
        self,
        path: Path,
        asset: Asset | None = None,
        loop: Loop = "no",
        *,
        start_at_ns: int | None = None,
    ) -> None:
        """Opens a recording.

        Args:
            path: the file.
            asset: takes the place of the parts that it names.
            loop, start_at_ns: as in `RecordedSource`.

        Raises:
            RecordingError: it cannot be read, has no frame, or its asset is not here.
            MeshError: a mesh is refused.
        """
        self.opened = OpenRecording(path)
        self._shown = [each for each in self.opened.results if each.images is not None]
        try:
            super().__init__(self._described(path, asset), loop, start_at_ns=start_at_ns)
        except BaseException:
            self.opened.close()
            raise

    def close(self) -> None:
        """Ends the decoding thread and closes the file; may be called twice."""
        super().close()
        self.opened.close()

    def _described(self, path: Path, asset: Asset | None) -> Recording:
        opened = self.opened
        if not self._shown:
            raise RecordingError(path, "holds no frame")
        asset = opened.asset(asset)
        parts = opened.parts(asset)
        names = {part.name for part in parts}
        poses = opened.station.initial_poses.items()
        return Recording(
            name=path.name,
            directory=path,
            camera=opened.camera,
            frame_rate_hz=opened.station.frame_rate_hz,
            frames=tuple(FrameFiles(each.frame, path, None) for each in self._shown),
            parts=parts,
            initial_poses={name: pose_of(pose) for name, pose in poses if name in names},
            asset=asset,
        )

    def _decode(self, number: int, index: int) -> Frame:
        frame = self.opened.frame(self._shown[index])
        captured_at_ns = self._start_at_ns + round(number * 1e9 / self.frame_rate_hz)
        return Frame(frame.name, captured_at_ns, frame.color, frame.depth)
