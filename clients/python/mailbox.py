"""Between a stream that goes on by itself and somebody who takes from it when there is time."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import deque
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing
from typing import Generic, TypeVar

from snapfit.clients.python.events import Event
from snapfit.clients.python.snapshot import PoseSnapshot

T = TypeVar("T")
_MOST = 1000
_FULL_WAIT_S = 0.05


class Mailbox(Generic[T]):
    """What came and was not taken yet; may be used by two threads.

    Attributes:
        wake: called whenever there may be something to take.
    """

    def __init__(self) -> None:
        self.wake: Callable[[], None] = lambda: None
        self._lock = threading.Lock()
        self._error: BaseException | None = None
        self._has_ended = False

    def put(self, item: T) -> None:
        """Something came."""
        raise NotImplementedError

    def take(self) -> T | None:
        """What is next, if it is there."""
        raise NotImplementedError

    @property
    def is_full(self) -> bool:
        """Whether it is better to wait with the next `put`."""
        return False

    @property
    def due_in_s(self) -> float | None:
        """When there is something to take even if nothing comes; None: never."""
        return None

    def end(self, error: BaseException | None = None) -> None:
        """Nothing will come any more; the first call counts."""
        if not self._has_ended:
            self._error, self._has_ended = error, True
        self.wake()

    @property
    def has_ended(self) -> bool:
        """Whether nothing will come any more; what came before can still be taken."""
        return self._has_ended

    def raise_error(self) -> None:
        """Raise the error with which it ended, if it was one."""
        if self._error is not None:
            raise self._error


class Latest(Mailbox[PoseSnapshot]):
    """The latest snapshot wins. In silence the last one is given once more, as stale.

    Args:
        stale_after_s: of silence.
    """

    def __init__(self, stale_after_s: float) -> None:
        super().__init__()
        self._stale_after_s = stale_after_s
        self._came: PoseSnapshot | None = None
        self._taken: PoseSnapshot | None = None
        self._came_at_s = 0.0

    def put(self, item: PoseSnapshot) -> None:
        """Takes the place of one that was not taken."""
        with self._lock:
            self._came_at_s = time.monotonic()
            is_known = self._taken is not None and item.version == self._taken.version
            self._came = None if is_known else item
        self.wake()

    def take(self) -> PoseSnapshot | None:
        """The latest one, if it was not taken yet."""
        with self._lock:
            if self._came is not None:
                self._taken, self._came = self._came, None
                return self._taken
            due_in_s = self.due_in_s
            if due_in_s is None or due_in_s > 0 or self._taken is None:
                return None
            passed_us = round((time.monotonic() - self._came_at_s) * 1e6)
            age_us = self._taken.age_us + passed_us
            self._taken = self._taken.model_copy(update={"stale": True, "age_us": age_us})
            return self._taken

    @property
    def due_in_s(self) -> float | None:
        """When the one that was taken last is stale."""
        if self._taken is None or self._taken.stale:
            return None
        return self._came_at_s + self._stale_after_s - time.monotonic()


class InOrder(Mailbox[Event]):
    """Every event, in order."""

    def __init__(self) -> None:
        super().__init__()
        self._events: deque[Event] = deque()

    def put(self, item: Event) -> None:
        """The last of all."""
        self._events.append(item)
        self.wake()

    def take(self) -> Event | None:
        """The first of those that were not taken."""
        return self._events.popleft() if self._events else None

    @property
    def is_full(self) -> bool:
        """The server keeps 1000 events for those who come back."""
        return len(self._events) >= _MOST


async def fill(mailbox: Mailbox[T], stream: AsyncGenerator[T, None]) -> None:
    """Put all that comes into a mailbox, until the stream ends or this is cancelled."""
    error: BaseException | None = None
    try:
        async with aclosing(stream):
            async for item in stream:
                while mailbox.is_full:
                    await asyncio.sleep(_FULL_WAIT_S)
                mailbox.put(item)
    except Exception as failure:  # noqa: BLE001 - raised again where it is taken
        error = failure
    finally:
        mailbox.end(error)
