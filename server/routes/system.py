"""The server itself: its time, whether it lives, whether it has something to say."""

from __future__ import annotations

from http import HTTPStatus
from importlib.metadata import version
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from snapfit.server.gbot_resource import gbot_parts
from snapfit.server.metrics import CONTENT_TYPE, Metrics
from snapfit.server.problems import ProblemError, problem_responses
from snapfit.server.request_clock import RECEIVED_AT_US
from snapfit.server.routes.dependencies import AllStations, OneStation
from snapfit.server.routes.pose_query import LARGEST_INTEGER
from snapfit.server.schemas import GbotPart, Health, ServerTime

router = APIRouter(tags=["system"])

_RETRY_AFTER_S = 1
_METRICS: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "Prometheus' text format.",
        "content": {"text/plain": {"schema": {"type": "string"}}},
    }
}
ClientStamp = Annotated[
    int | None,
    Query(ge=0, le=LARGEST_INTEGER, description="The client's own clock, microseconds; sent back."),
]


@router.get("/v1/time", responses=problem_responses(HTTPStatus.UNPROCESSABLE_ENTITY))
async def get_time(
    request: Request, stations: AllStations, client_sent_at_us: ClientStamp = None
) -> ServerTime:
    """The server's clock: the time line of all time stamps, for a four-stamp synchronisation."""
    received_at_us = request.scope.get(RECEIVED_AT_US, stations.clock.now_us())
    return ServerTime(
        client_sent_at_us=client_sent_at_us,
        received_at_us=received_at_us,
        sent_at_us=stations.clock.now_us(),
    )


@router.get("/metrics", response_class=Response, responses=_METRICS)
async def get_metrics(request: Request) -> Response:
    """For Prometheus: frame times, ages, confidences, states, request latencies."""
    metrics: Metrics = request.app.state.metrics
    return Response(metrics.text(), media_type=CONTENT_TYPE)


@router.get(
    "/resource",
    responses=problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.SERVICE_UNAVAILABLE),
)
async def get_resource(station: OneStation) -> list[GbotPart]:
    """GBOT's own JSON, for clients made for its authors' server: the parts that have a pose."""
    return [GbotPart(**part) for part in gbot_parts(station.latest_snapshot())]


@router.get("/healthz")
async def get_healthz() -> Health:
    """200 while this process lives."""
    return Health(status="ok", version=version("snapfit"))


@router.get("/readyz", responses=problem_responses(HTTPStatus.SERVICE_UNAVAILABLE))
async def get_readyz(stations: AllStations) -> Health:
    """200 while every station has a fresh snapshot."""
    waiting = [station.info() for station in stations if not station.is_ready()]
    if waiting:
        detail = "; ".join(f"{info.station}: {info.worker.message}" for info in waiting)
        raise ProblemError(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "not-ready",
            f"No fresh snapshot from {detail}.",
            retry_after_s=_RETRY_AFTER_S,
        )
    return Health(status="ready", version=version("snapfit"))
