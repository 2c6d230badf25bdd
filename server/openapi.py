"""The OpenAPI document: FastAPI's, with problem details as the only error body."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI, Response
from fastapi.openapi.utils import get_openapi
from fastapi.responses import JSONResponse

from snapfit.server.schemas_base import Problem
from snapfit.server.security.openapi import add_security

OPENAPI_PATH = "/openapi.json"
_FASTAPI_ERRORS = ("HTTPValidationError", "ValidationError")


def install_openapi(app: FastAPI) -> None:
    """Make `app.openapi()` tell what this API really answers, and serve it, written once."""
    written: list[bytes] = []

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app)
        return app.openapi_schema

    app.openapi = document  # type: ignore[method-assign]

    @app.get(OPENAPI_PATH, include_in_schema=False)
    async def get_document() -> Response:
        """This API in OpenAPI's words."""
        if not written:
            written.append(bytes(JSONResponse(document()).body))
        return Response(written[0], media_type="application/json")


def prepare_openapi(app: FastAPI) -> None:
    """Make the document now: later it would hold up every other answer for a third of a second."""
    app.openapi()
    app.state.allowed_methods.prepare()


def _document(app: FastAPI) -> dict[str, Any]:
    document = get_openapi(
        title=app.title,
        summary=app.summary,
        description=app.description,
        version=app.version,
        routes=app.routes,
    )
    for operations in document["paths"].values():
        for operation in operations.values():
            invalid = operation["responses"].get("422")
            if invalid and "application/json" in invalid["content"]:
                del operation["responses"]["422"]
    schemas = document["components"]["schemas"]
    for name in _FASTAPI_ERRORS:
        schemas.pop(name, None)
    schemas["Problem"] = Problem.model_json_schema()
    add_security(document)
    return document
