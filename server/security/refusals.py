"""The problems with which a request is turned away at the door: 401, 403, 429."""

from __future__ import annotations

import math
from http import HTTPStatus

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from snapfit.server.problems import ProblemError, problem_response
from snapfit.server.security.roles import Role

_CHALLENGE = 'Bearer realm="snapfit"'


def key_needed() -> ProblemError:
    """401: no key at all."""
    return ProblemError(
        HTTPStatus.UNAUTHORIZED,
        "key-needed",
        "A key is needed: send the header 'Authorization: Bearer KEY', or open /?key=KEY in a "
        "browser once. `snapfit key add` makes one.",
    )


def wrong_key() -> ProblemError:
    """401: a key or a session that is none, or no more."""
    return ProblemError(
        HTTPStatus.UNAUTHORIZED,
        "wrong-key",
        "This key or session is not valid, or no more: `snapfit key list` tells which keys are.",
    )


def role_needed(needed: Role) -> ProblemError:
    """403: a key that is good for less."""
    return ProblemError(
        HTTPStatus.FORBIDDEN,
        "role-needed",
        f"This needs a key with the role {needed}: `snapfit key add NAME --role {needed}`.",
        role=needed,
    )


def foreign_origin(origin: str) -> ProblemError:
    """403: a web page from elsewhere."""
    return ProblemError(
        HTTPStatus.FORBIDDEN,
        "foreign-origin",
        f"Pages from {origin} may not do this: add it to security.cors_origins.",
    )


def foreign_host(host: str) -> ProblemError:
    """403: a name that may be somebody else's."""
    return ProblemError(
        HTTPStatus.FORBIDDEN,
        "foreign-host",
        f"This server, which needs no key, does not answer as {host}: add the name to "
        "security.hosts.",
    )


def too_many(wait_s: float, what: str) -> ProblemError:
    """429, with the time to wait."""
    wait_s = max(1, math.ceil(wait_s))
    return ProblemError(
        HTTPStatus.TOO_MANY_REQUESTS,
        "too-many-requests",
        f"Too many {what}: try again in {wait_s} s.",
        retry_after_s=wait_s,
    )


def refusal(path: str, error: ProblemError) -> Response:
    """The answer for a refusal at this path."""
    response = problem_response(path, error)
    if error.status is HTTPStatus.UNAUTHORIZED:
        response.headers["WWW-Authenticate"] = _CHALLENGE
    return response


async def refuse(error: ProblemError, scope: Scope, receive: Receive, send: Send) -> None:
    """Turn away an HTTP request or a WebSocket handshake."""
    await refusal(scope["path"], error)(scope, receive, send)
