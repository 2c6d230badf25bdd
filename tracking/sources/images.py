"""Decodes the image files of one frame, and says which is wrong and how."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.recording import FrameFiles
from snapfit.tracking.errors import FrameError
from snapfit.tracking.frame import Frame

Image = npt.NDArray[np.integer[Any]]

_PNG_START, _PNG_END = b"\x89PNG", b"IEND\xaeB`\x82"
_JPEG_START, _JPEG_END = b"\xff\xd8", b"\xff\xd9"


def read_frame(files: FrameFiles, camera: RgbdCamera, captured_at_ns: int) -> Frame:
    """Decodes one frame.

    Raises:
        FrameError: a file is missing, truncated or no image, its size does not fit the
            intrinsics, or its type is wrong.
    """
    color = _decode(files.name, files.color, cv2.IMREAD_COLOR).astype(np.uint8, copy=False)
    _check(files.name, files.color, color, camera.color, "color")
    depth: npt.NDArray[np.uint16] | None = None
    if files.depth is not None and camera.depth is not None:
        depth = _as_depth(
            files.name, files.depth, _decode(files.name, files.depth, cv2.IMREAD_UNCHANGED)
        )
        _check(files.name, files.depth, depth, camera.depth, "depth")
    return Frame(files.name, captured_at_ns, color, depth)


def _as_depth(name: str, path: Path, image: Image) -> npt.NDArray[np.uint16]:
    if image.dtype != np.uint16 or image.ndim != 2:
        channels = 1 if image.ndim == 2 else image.shape[2]
        problem = f"depth is one channel of uint16, this has {channels} of {image.dtype}"
        raise FrameError(name, f"{path}: {problem}")
    return image.astype(np.uint16, copy=False)


def _decode(name: str, path: Path, flags: int) -> Image:
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise FrameError(name, f"{path}: no such file") from error
    except OSError as error:
        raise FrameError(name, f"{path}: cannot be read: {error.strerror}") from error
    # OpenCV fills up a truncated image and says nothing; the end marker tells.
    for start, end in ((_PNG_START, _PNG_END), (_JPEG_START, _JPEG_END)):
        if data.startswith(start) and end not in data[-64:]:
            raise FrameError(name, f"{path}: is truncated after {len(data)} bytes")
    try:
        image: Image | None = cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error as error:  # a header that claims more pixels than OpenCV takes
        raise FrameError(name, f"{path}: cannot be decoded: {error.err}") from error
    if image is None:
        raise FrameError(name, f"{path}: is not a readable image ({len(data)} bytes)")
    return image


def _check(name: str, path: Path, image: Image, camera: PinholeCamera, which: str) -> None:
    height, width = image.shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise FrameError(
            name,
            f"{path}: is {width}x{height}, but the {which} intrinsics are for "
            f"{camera.width}x{camera.height}",
        )
