"""An MP4 file, written picture by picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.tracking.errors import SourceError


class VideoFile:
    """A film in the making; complete once closed."""

    def __init__(self, path: Path, frame_rate_hz: float, size_px: tuple[int, int]) -> None:
        """Begins a film.

        Args:
            path: the file, `.mp4`.
            frame_rate_hz: pictures a second.
            size_px: width and height.

        Raises:
            SourceError: the file cannot be written, or is no MP4.
        """
        if path.suffix.lower() != ".mp4":
            raise SourceError(f"{path}: films are MP4: call it {path.with_suffix('.mp4').name}")
        if not path.absolute().parent.is_dir():
            raise SourceError(f"{path}: there is no folder {path.absolute().parent}")
        code = cv2.VideoWriter.fourcc(*"mp4v")
        self._writer: Any = cv2.VideoWriter(str(path), code, frame_rate_hz, size_px)
        if not self._writer.isOpened():
            raise SourceError(f"{path}: cannot be written as a film")

    def add(self, image: npt.NDArray[np.uint8]) -> None:
        """Adds a picture (H, W, 3) uint8, BGR."""
        self._writer.write(image)

    def close(self) -> None:
        """Completes the film."""
        self._writer.release()
