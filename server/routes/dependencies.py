"""What handlers are given."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import Depends, Header, Path, Query, Request
from pydantic import BaseModel, ConfigDict, Field

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


async def only_station(stations: AllStations) -> Station:
    """The one station, where the path names none."""
    return stations.only()


class PoseQuery(BaseModel):
    """How poses are to be given."""

    model_config = ConfigDict(extra="forbid")

    convention: Literal["opencv"] = Field(
        default="opencv", description="Axes and handedness: x right, y down, z forward."
    )
    frame: Literal["camera"] = Field(
        default="camera", description="The frame that poses are given in."
    )


async def check_query(query: Annotated[PoseQuery, Query()]) -> None:
    """Refuses what cannot be given, rather than to give something else."""
    del query


NamedStation = Annotated[Station, Depends(named_station)]
OnlyStation = Annotated[Station, Depends(only_station)]
PartName = Annotated[str, Path(description="The part's name in its asset.")]
IfNoneMatch = Annotated[
    str | None, Header(description="The ETag of an earlier answer: 304 if nothing changed.")
]
