"""The server itself: its time, whether it lives, whether it has something to say."""

from __future__ import annotations

from http import HTTPStatus
from importlib.metadata import version

from fastapi import APIRouter

from snapfit.server.problems import ProblemError, problem_responses
from snapfit.server.routes.dependencies import AllStations
from snapfit.server.schemas import Health, ServerTime

router = APIRouter(tags=["system"])

_RETRY_AFTER_S = 1


@router.get("/v1/time")
async def get_time(stations: AllStations) -> ServerTime:
    """The server's clock: the time line of all time stamps."""
    received_at_us = stations.clock.now_us()
    return ServerTime(received_at_us=received_at_us, sent_at_us=stations.clock.now_us())


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
