"""A picture of a station's camera."""

from __future__ import annotations

from dataclasses import dataclass

import httpx

from snapfit.clients.python.errors import UnexpectedAnswerError


@dataclass(frozen=True)
class Picture:
    """A JPEG.

    Attributes:
        jpeg: the file's content.
        captured_at_us: exposure of its frame, Unix time by the server's clock, microseconds.
    """

    jpeg: bytes
    captured_at_us: int

    @staticmethod
    def of(response: httpx.Response) -> Picture:
        """The picture that an answer holds."""
        captured_at_us = response.headers.get("captured-at-us", "")
        if not captured_at_us.isdecimal():
            raise UnexpectedAnswerError("a picture without the header Captured-At-Us")
        return Picture(response.content, int(captured_at_us))
