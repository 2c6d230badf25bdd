"""Sends calls and reads their answers; the one place that knows of httpx's errors."""

from __future__ import annotations

from typing import Any, TypeVar

import httpx

from snapfit.clients.python.answer import unreachable
from snapfit.clients.python.calls import Call
from snapfit.clients.python.connection import Connection
from snapfit.clients.python.tags import Kept, Tags

T = TypeVar("T")


class Transport:
    """Waits for each answer."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self._tags = Tags()
        self._http = httpx.Client(**_options(connection))

    def do(self, call: Call[T]) -> T:
        """The answer to a call.

        Raises:
            ClientError: why there is none.
        """
        kept = self._tags.find(call)
        try:
            response = self._http.request(**_request(call, self.connection, kept))
        except httpx.HTTPError as error:
            unreachable(self.connection.url, error)
        return self._tags.read(call, response, kept)

    def close(self) -> None:
        """Close all connections."""
        self._http.close()


class AsyncTransport:
    """The same for asyncio.

    Attributes:
        http: for streams.
    """

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self._tags = Tags()
        self.http = httpx.AsyncClient(**_options(connection))

    async def do(self, call: Call[T]) -> T:
        """The answer to a call.

        Raises:
            ClientError: why there is none.
        """
        kept = self._tags.find(call)
        try:
            response = await self.http.request(**_request(call, self.connection, kept))
        except httpx.HTTPError as error:
            unreachable(self.connection.url, error)
        return self._tags.read(call, response, kept)

    async def aclose(self) -> None:
        """Close all connections."""
        await self.http.aclose()


def _options(connection: Connection) -> dict[str, Any]:
    # Without HTTPS there is nothing to check, and what checks takes 30 ms to make.
    verify: Any = connection.ssl_context or False
    return {
        "base_url": connection.url,
        "headers": connection.headers,
        "timeout": connection.timeout_s,
        "verify": verify,
    }


def _request(call: Call[T], connection: Connection, kept: Kept | None) -> dict[str, Any]:
    request: dict[str, Any] = {
        "method": call.method,
        "url": call.path,
        "timeout": httpx.Timeout(connection.timeout_s, read=connection.timeout_s + call.extra_s),
    }
    if call.query:
        request["params"] = dict(call.query)
    if call.body is not None:
        request["json"] = call.body
    if kept is not None:
        request["headers"] = {"If-None-Match": kept.etag}
    return request
