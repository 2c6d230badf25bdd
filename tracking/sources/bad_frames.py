"""Counts frames that cannot be used and tells of each fault once."""

from __future__ import annotations

from collections.abc import Callable

from snapfit.tracking.errors import FrameError

_MOST_REMEMBERED = 1000


class BadFrames:
    """The bad frames of one source.

    Attributes:
        count: how many there were.
    """

    def __init__(self, tell: Callable[[FrameError], None]) -> None:
        """Begin at zero.

        Args:
            tell: called for the first frame with a fault; a fault that comes again, as it does
                in a loop or with a broken camera, is only counted.
        """
        self.count = 0
        self._tell = tell
        self._told: set[str] = set()

    def add(self, error: FrameError) -> None:
        """Count a bad frame."""
        self.count += 1
        if error.problem not in self._told and len(self._told) < _MOST_REMEMBERED:
            self._told.add(error.problem)
            self._tell(error)
