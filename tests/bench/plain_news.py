"""A bare Starlette app's long poll and event stream: what the API's are compared with.

The state changes by itself, at a steady pace; whoever waits is woken by one `asyncio.Event`, and
gets bytes that are ready-made but for their four time stamps.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator

from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

_PERIOD_S = 0.5
_STATES = ("free", "mounted")
_ANSWER = (
    b'{"station":"bench-1","asset":"hobby-corner-clamp","boot_id":"07240ccb4f29","seq":1234,'
    b'"captured_at_us":%d,"published_at_us":%d,"stale":false,"state":"%b","finished_steps":[],'
    b'"next_steps":["mount-jaw"],"misassemblies":[],"confidence":0.99,"decided_by":"tracking",'
    b'"since_us":%d,"revision":%d,"age_us":12345}'
)
_EVENT = (
    b'id: 07240ccb-%d\nevent: state_changed\ndata: {"station":"bench-1","at_us":%d,'
    b'"boot_id":"07240ccb4f29","seq":1234,"captured_at_us":%d,"from_state":"%b","to_state":"%b",'
    b'"decided_by":"tracking","confidence":0.99}\n\n'
)


class PlainNews:
    """The state, and its routes."""

    def __init__(self) -> None:
        self._revision = 0
        self._next = asyncio.Event()
        self._answer = self._event = b""
        self._change()

    @property
    def routes(self) -> list[Route]:
        """Under the API's paths."""
        return [Route("/v1/assembly", self._assembly), Route("/v1/events", self._events)]

    async def run(self) -> None:
        """Change the state, for ever."""
        while True:
            await asyncio.sleep(_PERIOD_S)
            self._change()

    def _change(self) -> None:
        self._revision += 1
        at_us = time.time_ns() // 1000
        state = _STATES[self._revision % 2].encode()
        before = _STATES[(self._revision + 1) % 2].encode()
        self._answer = _ANSWER % (at_us, at_us, state, at_us, self._revision)
        self._event = _EVENT % (self._revision, at_us, at_us, before, state)
        event, self._next = self._next, asyncio.Event()
        event.set()

    async def _assembly(self, request: Request) -> Response:
        if int(request.query_params.get("after_revision", 0)) == self._revision:
            await self._next.wait()
        return Response(self._answer, media_type="application/json")

    async def _events(self, _request: Request) -> Response:
        return StreamingResponse(self._stream(), media_type="text/event-stream")

    async def _stream(self) -> AsyncIterator[bytes]:
        yield b"retry: 1000\n\n"
        while True:
            await self._next.wait()
            yield self._event
