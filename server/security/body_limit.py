"""No request body is read beyond a limit."""

from __future__ import annotations

from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from snapfit.server.problems import ProblemError
from snapfit.server.security.refusals import refuse
from snapfit.server.security.roles import SAFE_METHODS


class BodyLimit:
    """ASGI middleware.

    Args:
        app: what reads the bodies.
        limit_bytes: the longest body that is read.
    """

    def __init__(self, app: ASGIApp, limit_bytes: int) -> None:
        self._app = app
        self._limit_bytes = limit_bytes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse what says that it is too long; count what does not say."""
        if scope["type"] != "http" or scope["method"] in SAFE_METHODS:  # whose bodies none reads
            await self._app(scope, receive, send)
            return
        for name, value in scope["headers"]:
            if name == b"content-length" and int(value) > self._limit_bytes:
                await refuse(self._too_long(), scope, receive, send)
                return
        received_bytes = 0

        async def counted() -> Message:
            nonlocal received_bytes
            message = await receive()
            received_bytes += len(message.get("body", b""))
            if received_bytes > self._limit_bytes:
                # Of all exceptions this one passes through FastAPI's reading of bodies.
                raise HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, self._too_long().detail)
            return message

        await self._app(scope, counted, send)

    def _too_long(self) -> ProblemError:
        return ProblemError(
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
            "body-too-long",
            f"The request's body is longer than {self._limit_bytes} bytes, which is "
            "security.request_bytes.",
        )
