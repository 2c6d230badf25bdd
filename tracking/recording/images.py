"""Images as they lie in a recording: PNG without loss, or colour as JPEG."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.tracking.errors import FrameError
from snapfit.tracking.recording.records import ColorFormat

JPEG_QUALITY = 92

# Measured on 1280x720 with a camera's noise: half the time of OpenCV's default, and smaller.
_SIDEWAYS = (
    [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_SUB]
    if hasattr(cv2, "IMWRITE_PNG_FILTER_SUB")
    else []
)
_COLOR_PNG = [
    *(cv2.IMWRITE_PNG_COMPRESSION, 1),
    *(cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY),
    *_SIDEWAYS,
]
_DEPTH_PNG = [
    *(cv2.IMWRITE_PNG_COMPRESSION, 1),
    *(cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE),
    *_SIDEWAYS,
]


def encode_color(image: npt.NDArray[np.uint8], kind: ColorFormat) -> bytes:
    """A colour image (H, W, 3) uint8 BGR as PNG, the same pixels, or as JPEG, nearly so."""
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if kind == "jpeg" else _COLOR_PNG
    return _encode(".jpg" if kind == "jpeg" else ".png", image, options)


def encode_depth(image: npt.NDArray[np.uint16]) -> bytes:
    """A depth image (H, W) uint16 as PNG, the same values."""
    return _encode(".png", image, _DEPTH_PNG)


def decode(name: str, which: str, data: bytes, dtype: type, n_dimensions: int) -> npt.NDArray[Any]:
    """The image that was encoded.

    Args:
        name, which: the frame's name and "colour" or "depth", for the error.
        data: PNG or JPEG.
        dtype, n_dimensions: that it must have.

    Raises:
        FrameError: it cannot be decoded, or is of another kind.
    """
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise FrameError(name, f"the {which} image cannot be decoded: {error.err}") from error
    if image is None or image.dtype != dtype or image.ndim != n_dimensions:
        raise FrameError(name, f"the {which} image in the recording is damaged")
    return np.asarray(image)


def _encode(suffix: str, image: npt.NDArray[Any], options: list[int]) -> bytes:
    done, data = cv2.imencode(suffix, image, options)
    if not done:  # nothing that a frame's images can be; OpenCV raises for all that is known
        raise FrameError("", f"an image {image.shape} {image.dtype} cannot be encoded")
    return bytes(data)
