"""How a picture travels through the store: its snapshot, its exposure, the JPEG."""

from __future__ import annotations

import struct
from typing import NamedTuple

_HEADER = struct.Struct("<QQ")


class PictureMessage(NamedTuple):
    """A picture and what it shows.

    Attributes:
        generation: of the snapshot in the store that belongs to this frame.
        captured_at_us: exposure, Unix time, microseconds.
        jpeg: the encoded image.
    """

    generation: int
    captured_at_us: int
    jpeg: bytes


def pack_picture(generation: int, captured_at_us: int, jpeg: bytes) -> bytes:
    """The bytes of a `PictureMessage`."""
    return _HEADER.pack(generation, captured_at_us) + jpeg


def unpack_picture(message: bytes) -> PictureMessage:
    """The inverse of `pack_picture`."""
    generation, captured_at_us = _HEADER.unpack_from(message)
    return PictureMessage(generation, captured_at_us, message[_HEADER.size :])
