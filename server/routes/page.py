"""The page and its files, as they were built, from the package of web clients."""

from __future__ import annotations

import gzip
import hashlib
from importlib.resources import files
from pathlib import PurePath

from fastapi import APIRouter, Request, Response
from fastapi.routing import APIRoute

from snapfit.server.errors import InstallationError

_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}
_PATHS = {"index.html": "/", "docs.html": "/docs"}
# Asked for at every visit, and sent only where it has changed: a page and a server of different
# versions would not understand each other.
_HEADERS = {"Cache-Control": "no-cache", "Vary": "Accept-Encoding"}


def page_router() -> APIRouter:
    """`/` and the files that it needs; read once, now.

    Raises:
        InstallationError: they are not there.
    """
    router = APIRouter(include_in_schema=False)
    folder = files("snapfit.clients.web") / "dist"
    found = sorted(folder.iterdir(), key=lambda file: file.name) if folder.is_dir() else []
    for file in found:
        media_type = _TYPES.get(PurePath(file.name).suffix)
        if media_type is not None:
            path = _PATHS.get(file.name, f"/{file.name}")
            router.add_api_route(path, _Asset(file.read_bytes(), media_type).get)
    if "/" not in page_paths(router):
        raise InstallationError(f"{folder}: the page is missing: install snapfit anew")
    return router


def page_paths(router: APIRouter) -> list[str]:
    """The paths of these files."""
    return [route.path for route in router.routes if isinstance(route, APIRoute)]


class _Asset:
    """One file."""

    def __init__(self, content: bytes, media_type: str) -> None:
        self._content = content
        self._compressed = gzip.compress(content, mtime=0)
        self._media_type = media_type
        self._headers = {**_HEADERS, "ETag": f'W/"{hashlib.sha256(content).hexdigest()[:16]}"'}

    async def get(self, request: Request) -> Response:
        """The file, or that it is the one which the browser has."""
        if self._headers["ETag"] in request.headers.get("if-none-match", ""):
            return Response(status_code=304, headers=self._headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            headers = {**self._headers, "Content-Encoding": "gzip"}
            return Response(self._compressed, headers=headers, media_type=self._media_type)
        return Response(self._content, headers=self._headers, media_type=self._media_type)
