"""The first page, from the package of web clients."""

from __future__ import annotations

from importlib.resources import files

from fastapi import APIRouter, Response

_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}
_HEADERS = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:",
    "X-Content-Type-Options": "nosniff",
}


def page_router() -> APIRouter:
    """`/` and the files that it needs; read once, now."""
    router = APIRouter(include_in_schema=False)
    for file in files("snapfit.clients.web").iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix not in _TYPES:
            continue
        path = "/" if file.name == "index.html" else f"/{file.name}"
        router.add_api_route(path, _Asset(file.read_bytes(), _TYPES[suffix]).get)
    return router


class _Asset:
    """One file."""

    def __init__(self, content: bytes, media_type: str) -> None:
        self._content = content
        self._media_type = media_type

    async def get(self) -> Response:
        """The file."""
        return Response(self._content, headers=_HEADERS, media_type=self._media_type)
