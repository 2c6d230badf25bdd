"""What the OpenAPI document tells of keys, sessions and limits."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from snapfit.server.problems import problem_responses
from snapfit.server.security.roles import Role, role_for
from snapfit.server.security.session import COOKIE

_SCHEMES = {
    "key": {
        "type": "http",
        "scheme": "bearer",
        "description": "An API key; `snapfit key add` makes one. Not needed on a server that "
        "only its own machine can reach.",
    },
    "session": {
        "type": "apiKey",
        "in": "cookie",
        "name": COOKIE,
        "description": "A browser's session, from POST /v1/session or any address with ?key=.",
    },
}
_REFUSALS = (
    HTTPStatus.UNAUTHORIZED,
    HTTPStatus.FORBIDDEN,
    HTTPStatus.TOO_MANY_REQUESTS,
)
_OPEN = ("/healthz", "/v1/session")


def add_security(document: dict[str, Any]) -> None:
    """Add the schemes, and to each operation who may ask for it and how it may be refused."""
    document["components"]["securitySchemes"] = _SCHEMES
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            refusals = list(_REFUSALS)
            if role_for(method.upper()) is Role.OPERATE:
                refusals.append(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            if path in _OPEN:
                refusals.remove(HTTPStatus.UNAUTHORIZED)
            else:
                operation["security"] = [{"key": []}, {"session": []}]
            for status, response in problem_responses(*refusals).items():
                operation["responses"].setdefault(str(status), response)
