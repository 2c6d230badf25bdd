"""Every snapshot as it comes, over a WebSocket: the latest wins, nothing queues."""

from __future__ import annotations

import asyncio
import contextlib
import logging

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from snapfit.server.problems import ProblemError, invalid_request, problem_response
from snapfit.server.routes.dependencies import station_of
from snapfit.server.routes.pose_query import ViewQuery
from snapfit.server.station import Station
from snapfit.server.stream_response import SEND_LIMIT_S

router = APIRouter()

_WAIT_S = 0.5
_CLOSE_LIMIT_S = 0.5
_POLICY = 1008
_TRY_AGAIN_LATER = 1013
_GOING_AWAY = 1001
_LOG = logging.getLogger(__name__)


@router.websocket("/stream")
async def stream(websocket: WebSocket) -> None:
    """Sends a `PoseSnapshot` for every frame that the client can take."""
    try:
        station = await station_of(websocket, websocket.app.state.stations)
        query = _query(websocket)
        query.view(station)  # told now, while it can be told as a problem
    except ProblemError as error:
        await websocket.send_denial_response(problem_response(websocket.scope["path"], error))
        return
    await websocket.accept()
    reading = asyncio.create_task(_read(websocket))
    try:
        code = await _send_all(websocket, station, query, reading)
        async with asyncio.timeout(_CLOSE_LIMIT_S):
            await websocket.close(code)
    except (WebSocketDisconnect, RuntimeError, TimeoutError):
        pass  # the client left meanwhile, or does not even read that it is to leave
    finally:
        reading.cancel()
        await asyncio.gather(reading, return_exceptions=True)


def _query(websocket: WebSocket) -> ViewQuery:
    try:
        return ViewQuery.model_validate(dict(websocket.query_params))
    except ValidationError as error:
        raise invalid_request(error.errors(), "query") from error


async def _send_all(
    websocket: WebSocket, station: Station, query: ViewQuery, reading: asyncio.Task[None]
) -> int:
    """Until the client leaves, does not read, or the server ends: how to close."""
    sent = None
    while not reading.done() and not station.watch.is_ending:
        moment = station.moment()
        # Nobody was here to be woken by what came while the last one was sent.
        if moment is None or moment == sent:
            await station.watch.change(_WAIT_S)
            continue
        try:
            view = query.view(station)
        except ProblemError:  # the anchor has expired
            return _POLICY
        body = station.poses(view).body(station.now_us())
        try:
            async with asyncio.timeout(SEND_LIMIT_S):
                await websocket.send_text(body.decode())
        except TimeoutError:
            _LOG.warning("%s: a client that does not read is dropped", websocket.scope["path"])
            websocket.app.state.metrics.dropped.inc()
            return _TRY_AGAIN_LATER
        sent = moment
    return _GOING_AWAY


async def _read(websocket: WebSocket) -> None:
    """Takes in what the client says, which is nothing that matters, until it leaves."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while (await websocket.receive())["type"] != "websocket.disconnect":
            pass
