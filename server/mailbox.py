"""A place in shared memory for the latest message: one writer, any number of readers, no locks.

Two slots are written in turn. A message carries its generation (1, 2, 3, ...) and a digest of
generation, length and bytes; `latest` names the newest complete one. A writer killed half-way
leaves the slot that nobody reads; a reader that is overtaken while it copies, or that sees the
writer's stores out of order (as ARM allows), finds a digest that does not fit and reads again.
"""

from __future__ import annotations

import hashlib
import struct
from typing import NamedTuple

from snapfit.server.errors import StoreError

_HEADER_BYTES = 64  # one cache line: `latest`
_SLOT_HEADER_BYTES = 64  # generation, length, digest
_DIGEST_BYTES = 16
_TRIES = 1000


class Message(NamedTuple):
    """A message and its generation, which grows by one with each message."""

    generation: int
    payload: bytes


class _Slot:
    """Views into one slot."""

    def __init__(self, buffer: memoryview) -> None:
        self.head = buffer[:16].cast("Q")
        self.digest = buffer[16 : 16 + _DIGEST_BYTES]
        self.payload = buffer[_SLOT_HEADER_BYTES:]

    def release(self) -> None:
        for view in (self.head, self.digest, self.payload):
            view.release()


class Mailbox:
    """The latest message in a stretch of shared memory.

    Args:
        buffer: `Mailbox.size_bytes(capacity)` bytes, zero at first, aligned to 8.
    """

    def __init__(self, buffer: memoryview) -> None:
        slot_bytes = (len(buffer) - _HEADER_BYTES) // 2
        self.capacity_bytes = slot_bytes - _SLOT_HEADER_BYTES
        self._latest = buffer[:8].cast("Q")
        first = _HEADER_BYTES
        self._slots = (
            _Slot(buffer[first : first + slot_bytes]),
            _Slot(buffer[first + slot_bytes : first + 2 * slot_bytes]),
        )

    @staticmethod
    def size_bytes(capacity_bytes: int) -> int:
        """What a mailbox for messages of up to `capacity_bytes` (a multiple of 64) takes."""
        return _HEADER_BYTES + 2 * (_SLOT_HEADER_BYTES + capacity_bytes)

    @property
    def latest(self) -> int:
        """The generation of the newest message, 0 before the first one."""
        return self._latest[0]

    def write(self, payload: bytes) -> int:
        """Publish a message, which becomes the latest; its generation.

        Raises:
            StoreError: it is larger than the capacity.
        """
        if len(payload) > self.capacity_bytes:
            raise StoreError(
                f"a message of {len(payload)} bytes does not fit the {self.capacity_bytes} bytes "
                "of shared memory that are set aside for it"
            )
        generation = self._latest[0] + 1
        slot = self._slots[generation % 2]
        slot.head[0] = generation
        slot.head[1] = len(payload)
        slot.payload[: len(payload)] = payload
        slot.digest[:] = _digest(generation, payload)
        self._latest[0] = generation
        return generation

    def read(self) -> Message | None:
        """The latest message, None before the first one.

        Raises:
            StoreError: the memory is damaged (no whole message after many tries).
        """
        for _ in range(_TRIES):
            generation = self._latest[0]
            if generation == 0:
                return None
            slot = self._slots[generation % 2]
            length = slot.head[1]
            if slot.head[0] != generation or length > self.capacity_bytes:
                continue
            digest = bytes(slot.digest)
            payload = bytes(slot.payload[:length])
            if digest == _digest(generation, payload):
                return Message(generation, payload)
        raise StoreError(f"no whole message in shared memory after {_TRIES} tries: it is damaged")

    def release(self) -> None:
        """Let go of the memory, so that its segment can be closed."""
        self._latest.release()
        for slot in self._slots:
            slot.release()


def _digest(generation: int, payload: bytes) -> bytes:
    digest = hashlib.blake2b(struct.pack("<QQ", generation, len(payload)), digest_size=16)
    digest.update(payload)
    return digest.digest()
