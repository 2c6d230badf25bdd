"""One error body everywhere: problem details, RFC 9457."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

import orjson
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException

from snapfit.server.allow import AllowedMethods
from snapfit.server.schemas_base import Problem

PROBLEM_TYPE = "application/problem+json"
_PHRASES = {413: "Content Too Large", 422: "Unprocessable Content"}
_LOG = logging.getLogger(__name__)


class ProblemError(Exception):
    """A request that cannot be answered.

    Args:
        status: the HTTP status.
        kind: what kind of problem, for programs; becomes `urn:snapfit:problem:<kind>`.
        detail: what is wrong and what to do, for people.
        retry_after_s: when it is worth trying again.
        members: further members of the body.
    """

    def __init__(
        self,
        status: HTTPStatus,
        kind: str,
        detail: str,
        *,
        retry_after_s: int | None = None,
        **members: Any,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.kind = kind
        self.detail = detail
        self.retry_after_s = retry_after_s
        self.members = members


def problem_responses(*statuses: HTTPStatus) -> dict[int | str, dict[str, Any]]:
    """What OpenAPI says of a route that may answer with these problems."""
    reference = {"schema": {"$ref": "#/components/schemas/Problem"}}
    return {
        status.value: {"description": _title(status), "content": {PROBLEM_TYPE: reference}}
        for status in statuses
    }


def install_problem_handlers(app: FastAPI) -> None:
    """Make every error of the app a problem."""
    app.state.allowed_methods = AllowedMethods(app)
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(HTTPException, _on_http_exception)
    app.add_exception_handler(RequestValidationError, _on_invalid_request)
    app.add_exception_handler(Exception, _on_bug)


def problem_response(path: str, error: ProblemError) -> Response:
    """The answer for a problem at this path."""
    headers = {} if error.retry_after_s is None else {"Retry-After": str(error.retry_after_s)}
    kind = f"urn:snapfit:problem:{error.kind}"
    return _response(path, error.status, error.detail, kind, headers, **error.members)


async def _on_problem(request: Request, error: Exception) -> Response:
    if not isinstance(error, ProblemError):
        raise error
    return problem_response(request.scope["path"], error)


async def _on_http_exception(request: Request, error: Exception) -> Response:
    if not isinstance(error, HTTPException):
        raise error
    status = HTTPStatus(error.status_code)
    detail = str(error.detail)
    if status is HTTPStatus.NOT_FOUND:
        detail = "There is nothing at this path; /openapi.json tells all paths."
        if request.scope["path"].endswith("/"):
            detail += " None but / ends in a slash."
    headers = dict(error.headers or {})
    if status is HTTPStatus.METHOD_NOT_ALLOWED:
        detail = f"{request.method} is not possible here; the header Allow tells what is."
        methods = request.app.state.allowed_methods.at(request.scope["path"])
        headers = {"Allow": ", ".join(methods)} if methods else headers
    return _response(request.scope["path"], status, detail, "about:blank", headers)


def invalid_request(details: Sequence[Any], origin: str = "") -> ProblemError:
    """422 for what pydantic refused.

    Args:
        details: its errors.
        origin: where the values came from, where pydantic does not say so itself.
    """
    errors = [
        {"where": ".".join(filter(None, [origin, *map(str, item["loc"])])), "what": item["msg"]}
        for item in details
    ]
    detail = "; ".join(f"{item['where']}: {item['what']}" for item in errors)
    return ProblemError(HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-request", detail, errors=errors)


async def _on_invalid_request(request: Request, error: Exception) -> Response:
    if not isinstance(error, RequestValidationError):
        raise error
    return problem_response(request.scope["path"], invalid_request(error.errors()))


async def _on_bug(request: Request, error: Exception) -> Response:
    _LOG.error("%s %s failed", request.method, request.scope["path"], exc_info=error)
    detail = "The server made a mistake; its log tells more."
    return _response(
        request.scope["path"], HTTPStatus.INTERNAL_SERVER_ERROR, detail, "about:blank", {}
    )


def _response(
    path: str, status: HTTPStatus, detail: str, kind: str, headers: dict[str, str], **members: Any
) -> Response:
    problem = Problem(type=kind, title=_title(status), status=status, detail=detail, instance=path)
    body = orjson.dumps({**problem.model_dump(), **members})
    headers = {"Cache-Control": "no-store", **headers}
    return Response(body, status, headers, media_type=PROBLEM_TYPE)


def _title(status: HTTPStatus) -> str:
    """RFC 9110's phrase; Python before 3.13 has older ones for 413 and 422."""
    return _PHRASES.get(status.value, status.phrase)
