"""What comes by itself, each over one connection: snapshots and events."""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing
from typing import Literal
from urllib.parse import urlencode

import httpx

from snapfit.clients.python.answer import check, parsed, problem, unreachable
from snapfit.clients.python.backoff import Backoff, reconnecting
from snapfit.clients.python.calls import Axes, StationCalls, view_query
from snapfit.clients.python.errors import UnexpectedAnswerError
from snapfit.clients.python.events import Event, EventReader
from snapfit.clients.python.snapshot import PoseSnapshot
from snapfit.clients.python.transport import AsyncTransport

Way = Literal["auto", "websocket", "poll"]
"""How snapshots come: `auto` is `websocket` where that is possible, else `poll`."""

OnOpen = Callable[[], None]
"""Called whenever events come from a server: what happens from now on is told."""

_PING_S = 5.0
_POLL_S = 20.0
_EVENT_SILENCE_S = 25.0
_LARGEST_BYTES = 2**24
_LOG = logging.getLogger("snapfit.clients.python")


def can_websocket() -> bool:
    """Whether the library for WebSockets is installed."""
    return importlib.util.find_spec("websockets") is not None


class Streams:
    """The streams of one station.

    Args:
        transport: to its server.
        calls: of the station.
    """

    def __init__(self, transport: AsyncTransport, calls: StationCalls) -> None:
        self._transport = transport
        self._calls = calls

    def snapshots(
        self, convention: Axes, frame: str, way: Way, backoff: Backoff
    ) -> AsyncGenerator[PoseSnapshot, None]:
        """Snapshots, for ever.

        Raises:
            ClientError: it is no use to try again.
        """

        def open_stream() -> AsyncGenerator[PoseSnapshot, None]:
            match way:
                case "websocket":
                    return self._sent(convention, frame)
                case "poll":
                    return self._polled(convention, frame)
                case "auto":
                    return self._sent_or_polled(convention, frame)

        return reconnecting(open_stream, backoff)

    def events(
        self, last_event_id: str, backoff: Backoff, on_open: OnOpen | None = None
    ) -> AsyncGenerator[Event, None]:
        """Events, for ever; none is missed as long as the server keeps them.

        Raises:
            ClientError: it is no use to try again.
        """
        reader = EventReader(last_event_id)
        return reconnecting(lambda: self._events(reader, on_open), backoff)

    async def _sent_or_polled(
        self, convention: Axes, frame: str
    ) -> AsyncGenerator[PoseSnapshot, None]:
        if can_websocket():
            try:
                async with aclosing(self._sent(convention, frame)) as snapshots:
                    async for snapshot in snapshots:
                        yield snapshot
            except UnexpectedAnswerError as error:
                _LOG.info("no WebSocket here, polling instead: %s", error)
            else:
                return
        async with aclosing(self._polled(convention, frame)) as snapshots:
            async for snapshot in snapshots:
                yield snapshot

    async def _sent(self, convention: Axes, frame: str) -> AsyncGenerator[PoseSnapshot, None]:
        """Over a WebSocket."""
        from websockets.asyncio.client import connect
        from websockets.exceptions import InvalidHandshake, InvalidStatus, WebSocketException

        connection = self._transport.connection
        path = f"{self._calls.base}/stream"
        query = urlencode(view_query(convention, frame))
        try:
            async with connect(
                f"{connection.websocket_url}{path}?{query}",
                additional_headers=connection.headers,
                ssl=connection.ssl_context,
                compression=None,
                open_timeout=connection.timeout_s,
                ping_interval=_PING_S,
                ping_timeout=connection.timeout_s,
                close_timeout=1,
                max_size=_LARGEST_BYTES,
            ) as socket:
                async for message in socket:
                    yield parsed(PoseSnapshot, message, path)
        except InvalidStatus as error:
            answer = error.response
            kind = answer.headers.get("content-type", "").partition(";")[0]
            wait = answer.headers.get("retry-after")
            raise problem(
                answer.status_code, kind, bytes(answer.body or b""), wait, path
            ) from error
        except InvalidHandshake as error:
            if isinstance(error.__cause__, EOFError | OSError):  # it went away meanwhile
                unreachable(connection.url, error)
            raise UnexpectedAnswerError(f"{path}: no WebSocket: {error}") from error
        except (OSError, TimeoutError, WebSocketException) as error:
            unreachable(connection.url, error)

    async def _polled(self, convention: Axes, frame: str) -> AsyncGenerator[PoseSnapshot, None]:
        """By long poll."""
        call = self._calls.poses(convention, frame, None, is_tagged=False)
        last = await self._transport.do(call)
        yield last
        while True:
            call_next = self._calls.next_poses(*last.identity, convention, frame, _POLL_S)
            snapshot = await self._transport.do(call_next)
            # After its time-out a stale station answers with the snapshot that we have.
            if snapshot is not None and snapshot.version != last.version:
                last = snapshot
                yield snapshot

    async def _events(
        self, reader: EventReader, on_open: OnOpen | None
    ) -> AsyncGenerator[Event, None]:
        """Over one connection."""
        connection = self._transport.connection
        reader.begin()
        timeout = httpx.Timeout(connection.timeout_s, read=_EVENT_SILENCE_S)
        headers = {"Last-Event-ID": reader.last_id} if reader.last_id else {}
        path = f"{self._calls.base}/events"
        try:
            async with self._transport.http.stream(
                "GET", path, headers=headers, timeout=timeout
            ) as response:
                if response.status_code != httpx.codes.OK:
                    await response.aread()
                    check(response)
                async for chunk in response.aiter_bytes():
                    if on_open is not None:  # the server has said where it begins
                        on_open()
                        on_open = None
                    for event in reader.feed(chunk):
                        yield event
        except httpx.HTTPError as error:
            unreachable(connection.url, error)
