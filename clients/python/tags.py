"""Entity tags: what the client has already is not sent again."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TypeVar

import httpx

from snapfit.clients.python.answer import check
from snapfit.clients.python.calls import Call
from snapfit.clients.python.snapshot import SnapshotHeader

T = TypeVar("T")
_KEPT = 16


@dataclass(frozen=True)
class Kept:
    """An earlier answer.

    Attributes:
        received_at_s: by the monotonic clock.
    """

    etag: str
    value: SnapshotHeader
    received_at_s: float

    def now(self) -> SnapshotHeader:
        """The same snapshot, as old as it is by now."""
        passed_us = round((time.monotonic() - self.received_at_s) * 1e6)
        return self.value.model_copy(update={"age_us": self.value.age_us + passed_us})


class Tags:
    """The latest answer to each of the last questions; may be used by several threads."""

    def __init__(self) -> None:
        self._kept: dict[object, Kept] = {}
        self._lock = threading.Lock()

    def find(self, call: Call[T]) -> Kept | None:
        """What there is of this call."""
        return self._kept.get(_question(call)) if call.is_tagged else None

    def read(self, call: Call[T], response: httpx.Response, kept: Kept | None) -> T:
        """What an answer says; `kept` is what `find` gave before it was asked for.

        Raises:
            ClientError: it says why there is no answer.
        """
        if kept is not None and response.status_code == httpx.codes.NOT_MODIFIED:
            return kept.now()  # type: ignore[return-value] # it was the answer to this call
        check(response)
        value = call.read(response)
        etag = response.headers.get("etag")
        if call.is_tagged and etag and isinstance(value, SnapshotHeader):
            with self._lock:
                self._kept.pop(_question(call), None)
                self._kept[_question(call)] = Kept(etag, value, time.monotonic())
                while len(self._kept) > _KEPT:
                    del self._kept[next(iter(self._kept))]
        return value


def _question(call: Call[T]) -> object:
    return call.path, tuple(call.query.items())
