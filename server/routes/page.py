"""The first page, from the package of web clients."""

from __future__ import annotations

from importlib.resources import files

from fastapi import APIRouter, Response
from fastapi.routing import APIRoute

_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}
_PATHS = {"index.html": "/", "docs.html": "/docs"}
_HEADERS = {"Cache-Control": "no-cache"}


def page_router() -> APIRouter:
    """`/` and the files that it needs; read once, now."""
    router = APIRouter(include_in_schema=False)
    for file in files("snapfit.clients.web").iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix not in _TYPES:
            continue
        path = _PATHS.get(file.name, f"/{file.name}")
        router.add_api_route(path, _Asset(file.read_bytes(), _TYPES[suffix]).get)
    return router


def page_paths(router: APIRouter) -> list[str]:
    """The paths of these files."""
    return [route.path for route in router.routes if isinstance(route, APIRoute)]


class _Asset:
    """One file."""

    def __init__(self, content: bytes, media_type: str) -> None:
        self._content = content
        self._media_type = media_type

    async def get(self) -> Response:
        """The file."""
        return Response(self._content, headers=_HEADERS, media_type=self._media_type)
