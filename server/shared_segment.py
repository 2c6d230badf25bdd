"""Shared memory with one owner: only who creates a segment removes it."""

from __future__ import annotations

import secrets
import sys
import threading
from collections.abc import Iterator, Sized
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.shared_memory import SharedMemory

from snapfit.server.errors import StoreError

_REGISTER_LOCK = threading.Lock()


def create_segment(size_bytes: int) -> SharedMemory:
    """A new segment, all zero. The caller owns it: it has to close and to unlink it.

    Python's resource tracker stays in charge of it, so that it is removed even when its owner
    is killed.
    """
    return SharedMemory(name=f"snapfit-{secrets.token_hex(8)}", create=True, size=size_bytes)


def attach_segment(name: str) -> SharedMemory:
    """Somebody else's segment. The caller only closes it.

    It is kept from Python's resource tracker, which would otherwise remove the owner's segment
    when this process ends (before Python 3.13 attaching always registers).

    Raises:
        StoreError: there is no such segment.
    """
    try:
        if sys.version_info >= (3, 13):
            return SharedMemory(name=name, track=False)
        with _no_registration():
            return SharedMemory(name=name)
    except FileNotFoundError as error:
        raise StoreError(f"no shared memory {name}: is the server that made it gone?") from error


@contextmanager
def _no_registration() -> Iterator[None]:
    def ignore(name: Sized, rtype: str) -> None:
        """Stands in for `resource_tracker.register` while a segment is attached."""
        del name, rtype

    with _REGISTER_LOCK:
        register = resource_tracker.register
        resource_tracker.register = ignore
        try:
            yield
        finally:
            resource_tracker.register = register
