"""Streams for those who do not use asyncio: one thread reads, and ends with whom it reads for."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import weakref
from collections.abc import AsyncGenerator, Callable, Generator
from typing import TypeVar

from snapfit.clients.python.calls import StationCalls
from snapfit.clients.python.connection import Connection
from snapfit.clients.python.mailbox import Mailbox, fill
from snapfit.clients.python.streams import Streams
from snapfit.clients.python.transport import AsyncTransport

T = TypeVar("T")
OpenStream = Callable[[Streams], AsyncGenerator[T, None]]


class Background:
    """A thread with an event loop of its own, in which a stream is read.

    Args:
        connection: to the server.
        calls: of the station.
        open_stream: makes the stream.
        mailbox: where it puts what comes.
    """

    def __init__(
        self,
        connection: Connection,
        calls: StationCalls,
        open_stream: OpenStream[T],
        mailbox: Mailbox[T],
    ) -> None:
        self._end = mailbox.end
        self._loop = asyncio.new_event_loop()
        self._task = self._loop.create_task(_read(connection, calls, open_stream, mailbox))
        self._thread = threading.Thread(target=self._run, name="snapfit-stream", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread; may be called twice, and by several threads."""
        with contextlib.suppress(RuntimeError):  # the loop has ended by itself
            self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join()
        self._end()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(_outcome(self._task))


class Readers:
    """The threads that read for one client, which ends them; may be used by several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._started: weakref.WeakSet[Background] = weakref.WeakSet()
        self._is_closed = False

    def start(self, begin: Callable[[], Background]) -> Background:
        """Another one.

        Raises:
            RuntimeError: the client has been closed.
        """
        with self._lock:
            if self._is_closed:
                raise RuntimeError("The client has been closed.")
            background = begin()
            self._started.add(background)
        return background

    def close(self) -> None:
        """End all, and start none any more."""
        with self._lock:
            self._is_closed = True
            started = list(self._started)
        for background in started:
            background.stop()


async def _outcome(task: asyncio.Task[None]) -> None:
    await asyncio.gather(task, return_exceptions=True)


async def _read(
    connection: Connection,
    calls: StationCalls,
    open_stream: OpenStream[T],
    mailbox: Mailbox[T],
) -> None:
    transport = AsyncTransport(connection)
    try:
        await fill(mailbox, open_stream(Streams(transport, calls)))
    finally:
        await transport.aclose()


def taken(
    start: Callable[[Mailbox[T]], Background], mailbox: Mailbox[T]
) -> Generator[T, None, None]:
    """All that comes into a mailbox; `close()` ends what fills it.

    Raises:
        ClientError: with which the stream ended.
    """
    change = threading.Condition()

    def wake() -> None:
        with change:
            change.notify()

    mailbox.wake = wake
    background = start(mailbox)
    try:
        while True:
            with change:
                has_ended = mailbox.has_ended  # asked first: what came before counts
                item = mailbox.take()
                if item is None and not has_ended:
                    due_in_s = mailbox.due_in_s
                    change.wait(None if due_in_s is None else max(due_in_s, 0))
                    continue
            if item is None:
                mailbox.raise_error()
                return
            yield item
    finally:
        background.stop()
