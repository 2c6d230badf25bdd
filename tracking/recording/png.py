"""PNG for recordings: as small as OpenCV's, in less than half of its time.

Most of the time of OpenCV's encoder is zlib's; Intel's ISA-L deflates several times faster,
and every reader of PNG understands it. Format: https://www.w3.org/TR/png-3.
"""

from __future__ import annotations

import struct
import zlib
from contextlib import suppress
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

_deflate: Any = zlib
with suppress(ImportError):  # there are processors that it is not made for
    from isal import isal_zlib as _deflate

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_SUB = 1
_LEVEL = 1
_GREY, _RGB = 0, 2


def encode_png(image: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes:
    """A colour image (H, W, 3) uint8 BGR, or a depth image (H, W) uint16, without loss."""
    if image.ndim == 3:
        rows = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB)).reshape(len(image), -1)
        return _file(rows, image.shape[1], bits=8, kind=_RGB, pixel_bytes=3)
    # Most significant byte first.
    rows = np.ascontiguousarray(image, dtype=">u2").view(np.uint8)
    return _file(rows, image.shape[1], bits=16, kind=_GREY, pixel_bytes=2)


def _file(rows: npt.NDArray[Any], width: int, *, bits: int, kind: int, pixel_bytes: int) -> bytes:
    height, n_bytes = rows.shape
    filtered = np.empty((height, 1 + n_bytes), dtype=np.uint8)
    # Each byte less the one of the pixel before: what is left is mostly noise around zero.
    filtered[:, 0] = _SUB
    filtered[:, 1 : 1 + pixel_bytes] = rows[:, :pixel_bytes]
    np.subtract(rows[:, pixel_bytes:], rows[:, :-pixel_bytes], out=filtered[:, 1 + pixel_bytes :])
    head = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    packed = _deflate.compress(filtered, _LEVEL)
    chunks = _chunk(b"IHDR", head) + _chunk(b"IDAT", packed) + _chunk(b"IEND", b"")
    return _SIGNATURE + chunks


def _chunk(kind: bytes, data: bytes) -> bytes:
    checksum = zlib.crc32(data, zlib.crc32(kind))
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", checksum)
