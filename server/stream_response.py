"""A response that goes on until the client leaves, the server ends, or the client does not read."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Mapping

from fastapi import Response
from starlette.types import Receive, Scope, Send

SEND_LIMIT_S = 5.0
"""A client that takes nothing for so long is dropped."""

_LOG = logging.getLogger(__name__)


class StreamResponse(Response):
    """Sends chunks as they come; the next one is made when the last one was taken.

    Args:
        chunks: they end when the server does.
        media_type: of the whole.
        headers: further ones.
    """

    def __init__(
        self,
        chunks: AsyncIterator[bytes],
        media_type: str,
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(headers={"Cache-Control": "no-store", **(headers or {})})
        del self.headers["content-length"]
        self.headers["content-type"] = media_type
        self._chunks = chunks

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Until it ends."""
        start = {"type": "http.response.start", "status": 200, "headers": self.raw_headers}
        await send(start)
        gone = asyncio.create_task(_disconnected(receive))
        sending = asyncio.create_task(self._send_all(scope, send))
        try:
            await asyncio.wait({gone, sending}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (gone, sending):
                task.cancel()
            await asyncio.gather(gone, sending, return_exceptions=True)

    async def _send_all(self, scope: Scope, send: Send) -> None:
        try:
            async for chunk in self._chunks:
                async with asyncio.timeout(SEND_LIMIT_S):
                    await send({"type": "http.response.body", "body": chunk, "more_body": True})
        except TimeoutError:
            _LOG.warning("%s: a client that does not read is dropped", scope["path"])
            scope["app"].state.metrics.dropped.inc()
        # Whoever does not read this either is cut off by the system (see `run`).
        await send({"type": "http.response.body", "body": b"", "more_body": False})


async def _disconnected(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
