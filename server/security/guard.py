"""The door: every request passes here before anything else looks at it."""

from __future__ import annotations

from http import HTTPStatus
from urllib.parse import parse_qsl, quote, urlencode

from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from snapfit.server.problems import ProblemError
from snapfit.server.security.access import Access
from snapfit.server.security.asking import Asking
from snapfit.server.security.key_file import KeyRecord
from snapfit.server.security.key_ring import KeyRing
from snapfit.server.security.refusals import refuse, wrong_key
from snapfit.server.security.session import session_cookie

_LANDING_METHODS = ("GET", "HEAD")
_POLICY_VIOLATION = 1008  # RFC 6455 section 7.4.1


class Guard:
    """ASGI middleware that turns away who may not ask."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let pass, send a browser with `?key=` on its way, or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        try:
            if _is_landing(scope):
                response = await self._land(scope)
                await response(scope, receive, send)
                return
            record = await self._access.check(scope)
        except ProblemError as error:
            await refuse(error, scope, receive, send)
            return
        if record is None or self._access.ring is None:
            await self._app(scope, receive, send)
            return
        scope.setdefault("state", {})["key_name"] = record.name
        until_removed = _UntilRemoved(self._access.ring, record, send)
        try:
            await self._app(scope, receive, until_removed)
        except (OSError, ClientDisconnect):
            if not until_removed.has_ended:
                raise

    async def _land(self, scope: Scope) -> Response:
        """A session for the key in the address, and the address without it."""
        query = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        rest = urlencode([(name, value) for name, value in query if name != "key"])
        # One slash at the start: two would lead to another host.
        path = "/" + quote(scope["path"].lstrip("/"))
        headers = {"Location": f"{path}?{rest}" if rest else path, "Cache-Control": "no-store"}
        ring = self._access.ring
        if ring is not None:
            address = Asking.of(scope).address
            record = await self._access.owner(ring, dict(query)["key"], address)
            if record is None:
                raise wrong_key()
            secure = scope["scheme"] == "https"
            headers["Set-Cookie"] = session_cookie(ring.new_session(record), secure=secure)
        return Response(status_code=HTTPStatus.SEE_OTHER, headers=headers)


class _UntilRemoved:
    """Sends until the key is removed: an open stream ends with it."""

    def __init__(self, ring: KeyRing, record: KeyRecord, send: Send) -> None:
        self._ring = ring
        self._record = record
        self._send = send
        self.has_ended = False

    async def __call__(self, message: Message) -> None:
        if message["type"] == "websocket.send":
            end: Message = {"type": "websocket.close", "code": _POLICY_VIOLATION}
        elif message.get("more_body", False):
            end = {"type": "http.response.body", "body": b""}
        else:
            await self._send(message)
            return
        if self._ring.holds(self._record):
            await self._send(message)
            return
        self.has_ended = True
        await self._send(end)
        # As if the client had gone, which every stream knows how to take.
        raise OSError("the key of this stream was removed")


def _is_landing(scope: Scope) -> bool:
    return (
        scope["type"] == "http"
        and scope["method"] in _LANDING_METHODS
        and b"key=" in scope["query_string"]
        and any(name == "key" for name, _ in parse_qsl(scope["query_string"].decode("latin-1")))
    )
