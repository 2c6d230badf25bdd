"""Stations: which there are, what they are like, how their workers do."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import APIRouter

from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import AllStations, NamedStation
from snapfit.server.schemas import StationInfo, StationList

router = APIRouter(prefix="/stations", tags=["stations"])


@router.get("")
async def get_stations(stations: AllStations) -> StationList:
    """All stations of this server."""
    return StationList(stations=[station.info() for station in stations])


@router.get("/{station}", responses=problem_responses(HTTPStatus.NOT_FOUND))
async def get_station(station: NamedStation) -> StationInfo:
    """One station: its asset, cameras, frame rate, and its worker's health."""
    return station.info()
