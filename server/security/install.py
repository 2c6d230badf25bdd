"""Puts security around the app, outermost last."""

from __future__ import annotations

from collections.abc import Iterable

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware

from snapfit.server.logs.requests import RequestLog
from snapfit.server.security.access import Access
from snapfit.server.security.body_limit import BodyLimit
from snapfit.server.security.first_key import key_file
from snapfit.server.security.guard import Guard
from snapfit.server.security.head import HeadAsGet
from snapfit.server.security.key_ring import KeyRing
from snapfit.server.security.settings import SecuritySettings, keys_needed

SESSION_PATH = "/v1/session"
_OPEN_PATHS = ("/healthz", "/openapi.json", SESSION_PATH)
_SEEN_BY_PAGES = ("ETag", "Captured-At-Us", "Retry-After", "X-Request-Id")
_SENT_BY_PAGES = ("Authorization", "Content-Type", "If-None-Match", "X-Request-Id")


def install_security(
    app: FastAPI, security: SecuritySettings, host: str, page_paths: Iterable[str]
) -> None:
    """Guard everything that the app has so far.

    Args:
        app: `app.state.access` becomes its rules.
        security: the table `[security]`.
        host: the address that the server listens at.
        page_paths: of the page and its files, which hold no secret.

    Raises:
        KeyFileError: the key file cannot be read.
    """
    ring = KeyRing(key_file(security)) if keys_needed(security, host) else None
    access = Access(security, ring, (*_OPEN_PATHS, *page_paths))
    app.state.access = access
    app.add_middleware(HeadAsGet)
    app.add_middleware(BodyLimit, limit_bytes=security.request_bytes)
    app.add_middleware(Guard, access=access)
    if security.cors_origins:
        anyone = "*" in security.cors_origins
        app.add_middleware(
            CORSMiddleware,
            allow_origins=["*"] if anyone else list(security.cors_origins),
            allow_credentials=not anyone,
            allow_methods=["GET", "HEAD", "POST", "PUT", "DELETE"],
            allow_headers=_SENT_BY_PAGES,
            expose_headers=_SEEN_BY_PAGES,
        )
    app.add_middleware(RequestLog)
