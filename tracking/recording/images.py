"""Images as they lie in a recording: PNG without loss, or colour as JPEG."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.tracking.errors import FrameError
from snapfit.tracking.recording.png import encode_png
from snapfit.tracking.recording.records import ColorFormat

JPEG_QUALITY = 92


def encode_color(image: npt.NDArray[np.uint8], kind: ColorFormat) -> bytes:
    """A colour image (H, W, 3) uint8 BGR as PNG, the same pixels, or as JPEG, nearly so."""
    if kind == "png":
        return encode_png(image)
    done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:  # nothing that a frame's image can be; OpenCV raises for all that is known
        raise FrameError("", f"an image {image.shape} {image.dtype} cannot be encoded")
    return bytes(data)


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
