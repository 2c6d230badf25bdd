"""A bug is a problem with the request's id, and the next request is answered."""

from __future__ import annotations

import asyncio
import logging

import httpx
import pytest
from fastapi import FastAPI

from snapfit.server.logs.requests import RequestLog


def test_a_bug_is_a_problem_and_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    app = FastAPI()
    app.add_middleware(RequestLog)

    @app.get("/bug")
    async def bug() -> None:
        raise KeyError("oh")

    @app.get("/fine")
    async def fine() -> str:
        return "yes"

    async def ask() -> tuple[httpx.Response, httpx.Response]:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            return await client.get("/bug"), await client.get("/fine")

    with caplog.at_level(logging.INFO):
        answer, after = asyncio.run(ask())
    assert (answer.status_code, after.status_code) == (500, 200)
    assert answer.json()["type"] == "urn:snapfit:problem:bug"
    assert "oh" not in answer.text
    assert answer.headers["x-request-id"]
    (logged,) = [record for record in caplog.records if record.exc_info]
    assert logged.getMessage() == "GET /bug failed"
