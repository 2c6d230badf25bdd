"""What happens at a station, as server-sent events."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Header, Response

from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import OneStation
from snapfit.server.station import Station
from snapfit.server.stream_response import StreamResponse

router = APIRouter(tags=["events"])

HEARTBEAT_S = 10.0
_WAIT_S = 1.0
_EVENT_STREAM = "text/event-stream"
_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "Events: state_changed, step_finished, step_undone, misassembled, "
        "part_found, part_lost, stale, recovered, anchor_drift; and `missed` first, where the "
        "events after Last-Event-ID are no longer kept. Before all, the id at which the stream "
        "begins. A comment every 10 s.",
        "content": {_EVENT_STREAM: {"schema": {"type": "string"}}},
    },
    **problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.UNPROCESSABLE_ENTITY),
}
LastEventId = Annotated[
    str | None, Header(description="The id of the last event that the client has.", max_length=64)
]


@router.get("/events", response_class=Response, responses=_RESPONSES)
async def get_events(station: OneStation, last_event_id: LastEventId = None) -> StreamResponse:
    """What happens from now on, or since the event that the client has."""
    return StreamResponse(_events(station, last_event_id), _EVENT_STREAM)


async def _events(station: Station, last_event_id: str | None) -> AsyncIterator[bytes]:
    log = station.news.events
    known = log.resume(last_event_id) if last_event_id else log.latest
    number = log.latest if known is None else known
    # With its id the client misses nothing either if it is cut off before the first event.
    missed = b"event: missed\ndata: {}\n" if known is None else b""
    yield b"retry: 1000\nid: %b\n%b\n" % (log.event_id(number).encode(), missed)
    said_at_s = time.monotonic()
    while not station.watch.is_ending:
        events = log.after(number)
        if events:
            number = events[-1].number
            yield b"".join(event.block for event in events)
            said_at_s = time.monotonic()
        if time.monotonic() - said_at_s >= HEARTBEAT_S:
            yield b": here\n\n"
            said_at_s = time.monotonic()
        if not events:  # else there may be more by now
            await station.watch.event(_WAIT_S)
