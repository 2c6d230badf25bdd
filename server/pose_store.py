"""The pose store: what the worker says and what the API asks, in shared memory.

Two segments. The first holds the worker's heartbeat, the snapshots, the worker's reports, what the
API orders and what the worker replies, and the markers that the camera sees; the second, much
larger one, the pictures and until when they are wanted. Pages that nobody writes take no memory.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from enum import StrEnum
from multiprocessing.shared_memory import SharedMemory

from snapfit.server.doorbell import Doorbell
from snapfit.server.errors import StoreError
from snapfit.server.mailbox import Mailbox
from snapfit.server.shared_segment import attach_segment, create_segment

_MAGIC = 0x736E61706669_0002  # "snapfi", then the version of this layout
_HEADER_BYTES = 64
_SNAPSHOT_BYTES = 256 * 1024
_REPORT_BYTES = 64 * 1024
_ORDER_BYTES = 64 * 1024
_PICTURE_BYTES = 8 * 1024 * 1024


class Picture(StrEnum):
    """What the camera sees, plain or with the parts drawn in."""

    FRAME = "frame"
    OVERLAY = "overlay"


@dataclass(frozen=True)
class StoreNames:
    """How another process finds a store."""

    poses: str
    pictures: str


class PoseStore:
    """The store as one process sees it; made by `create` (the owner) or `attach`.

    Attributes:
        snapshots: JSON of the latest pose snapshot.
        reports: JSON of the worker's latest report.
        orders: JSON of what the API wants done; it alone writes there.
        replies: JSON of what became of them.
        markers: JSON of the markers that the camera sees.
        pictures: the latest JPEG of each kind, behind a header (see `snapfit.server.pictures`).
        doorbell: rung when there is another snapshot; heard where the store was made.
    """

    def __init__(
        self, poses: SharedMemory, pictures: SharedMemory, doorbell: Doorbell, *, owner: bool
    ) -> None:
        self._segments = (poses, pictures)
        self.doorbell = doorbell
        self._owner = owner
        self._views: list[memoryview] = []
        self._header = self._view(poses, 0, _HEADER_BYTES).cast("Q")
        self._wanted = self._view(pictures, 0, _HEADER_BYTES).cast("Q")
        self.snapshots, self.reports, self.orders, self.replies, self.markers = (
            Mailbox(self._view(poses, at, size)) for at, size in _places()
        )
        size = Mailbox.size_bytes(_PICTURE_BYTES)
        self.pictures = {
            kind: Mailbox(self._view(pictures, _HEADER_BYTES + place * size, size))
            for place, kind in enumerate(Picture)
        }

    @staticmethod
    def create() -> PoseStore:
        """A new, empty store. Its maker owns it; `close` removes it."""
        poses_bytes = sum(_places()[-1])
        pictures_bytes = _HEADER_BYTES + len(Picture) * Mailbox.size_bytes(_PICTURE_BYTES)
        poses = create_segment(poses_bytes)
        try:
            pictures = create_segment(pictures_bytes)
        except OSError:
            poses.close()
            poses.unlink()
            raise
        store = PoseStore(poses, pictures, Doorbell.create(), owner=True)
        store._header[0] = _MAGIC
        return store

    @staticmethod
    def attach(names: StoreNames, rung: int | None = None) -> PoseStore:
        """Another process's store.

        Args:
            names: of the store.
            rung: its doorbell, a file descriptor that was inherited.

        Raises:
            StoreError: it does not exist, or was made by another version of snapfit.
        """
        poses = attach_segment(names.poses)
        try:
            _check_version(poses)
            pictures = attach_segment(names.pictures)
        except StoreError:
            poses.close()
            raise
        return PoseStore(poses, pictures, Doorbell(None, rung), owner=False)

    @property
    def names(self) -> StoreNames:
        """How another process finds this store."""
        return StoreNames(*(segment.name for segment in self._segments))

    def beat(self) -> None:
        """Say that the worker's loop is alive."""
        self._header[1] = time.monotonic_ns()

    def silent_for_s(self) -> float:
        """Seconds since the last `beat`."""
        return (time.monotonic_ns() - self._header[1]) / 1e9

    def want(self, kind: Picture, for_s: float) -> None:
        """Ask the worker for pictures of this kind for the next `for_s` seconds."""
        self._wanted[_PLACE[kind]] = time.monotonic_ns() + round(for_s * 1e9)

    def wanted(self, kind: Picture) -> bool:
        """Whether somebody asked for pictures of this kind lately."""
        return time.monotonic_ns() < self._wanted[_PLACE[kind]]

    def close(self) -> None:
        """Let go of the memory; the owner removes it. Closing twice does nothing."""
        small = (self.snapshots, self.reports, self.orders, self.replies, self.markers)
        for mailbox in (*small, *self.pictures.values()):
            mailbox.release()
        for view in (self._header, self._wanted, *self._views):
            view.release()
        for segment in self._segments:
            segment.close()
            if self._owner:
                segment.unlink()
        self._owner = False
        self.doorbell.close()

    def _view(self, segment: SharedMemory, at: int, size: int) -> memoryview:
        view = _memory(segment)[at : at + size]
        self._views.append(view)
        return view


def _places() -> list[tuple[int, int]]:
    """Where the mailboxes of the first segment lie: begin and size of each."""
    capacities = (_SNAPSHOT_BYTES, _REPORT_BYTES, _ORDER_BYTES, _ORDER_BYTES, _ORDER_BYTES)
    places, at = [], _HEADER_BYTES
    for capacity in capacities:
        size = Mailbox.size_bytes(capacity)
        places.append((at, size))
        at += size
    return places


def _memory(segment: SharedMemory) -> memoryview:
    if segment.buf is None:
        raise StoreError(f"shared memory {segment.name} is closed")
    return segment.buf


def _check_version(segment: SharedMemory) -> None:
    if int.from_bytes(_memory(segment)[:8], sys.byteorder) != _MAGIC:
        raise StoreError(f"shared memory {segment.name} was made by another version of snapfit")


_PLACE = {kind: place for place, kind in enumerate(Picture)}
