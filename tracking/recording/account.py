"""What has become of a recording, as the server tells it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class RecordingAccount:
    """What has become of a recording so far.

    Attributes:
        path: the file.
        frames: written with their images.
        dropped: frames whose images there was no time to write.
        n_bytes: written.
        problem: why it stopped; None while it goes on.
    """

    path: Path
    frames: int = 0
    dropped: int = 0
    n_bytes: int = 0
    problem: str | None = None
