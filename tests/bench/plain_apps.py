"""What the API is compared with: ready-made bytes. python plain_apps.py KIND PORT FILE."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import uvicorn
from fastapi import FastAPI
from plain_news import PlainNews
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

KIND, PORT, BODY = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]).read_bytes()


def minimal_fastapi() -> FastAPI:
    app = FastAPI()

    @app.get("/v1/poses")
    async def poses() -> Response:
        return Response(BODY, media_type="application/json")

    return app


def bare_starlette() -> Starlette:
    news = PlainNews()

    async def poses(_request: Request) -> Response:
        return Response(BODY, media_type="application/json")

    @asynccontextmanager
    async def lifespan(_app: Starlette) -> AsyncIterator[None]:
        changing = asyncio.create_task(news.run())
        yield
        changing.cancel()

    return Starlette(routes=[Route("/v1/poses", poses), *news.routes], lifespan=lifespan)


uvicorn.run(
    minimal_fastapi() if KIND == "fastapi" else bare_starlette(),
    port=PORT,
    loop="uvloop",
    http="httptools",
    access_log=False,
    server_header=False,
    log_level="warning",
    timeout_graceful_shutdown=1,
)
