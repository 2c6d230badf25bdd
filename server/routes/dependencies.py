"""What handlers are given."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Header, Path, Request
from starlette.requests import HTTPConnection

from snapfit.server.station import Station
from snapfit.server.stations import Stations


async def all_stations(request: Request) -> Stations:
    """The stations of this server."""
    stations: Stations = request.app.state.stations
    return stations


AllStations = Annotated[Stations, Depends(all_stations)]


async def named_station(
    stations: AllStations, station: Annotated[str, Path(description="The station's name.")]
) -> Station:
    """The station that the path names."""
    return stations.named(station)


async def station_of(request: HTTPConnection, stations: AllStations) -> Station:
    """The station that the path names; the only one, where it names none."""
    name: str | None = request.path_params.get("station")
    return stations.only() if name is None else stations.named(name)


NamedStation = Annotated[Station, Depends(named_station)]
OneStation = Annotated[Station, Depends(station_of)]
PartName = Annotated[str, Path(description="The part's name in its asset.")]
IfNoneMatch = Annotated[
    str | None, Header(description="The ETag of an earlier answer: 304 if nothing changed.")
]
