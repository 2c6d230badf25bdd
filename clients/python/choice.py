"""Which station is meant, and which asset."""

from __future__ import annotations

from snapfit.clients.python.errors import NoAssetError, UnknownStationError, WhichStationError
from snapfit.clients.python.station import StationInfo, StationList

_PATH = "/v1/stations"


def station_of(told: StationList, name: str | None) -> StationInfo:
    """The station of this name, or the only one.

    Raises:
        UnknownStationError: there is none of this name.
        WhichStationError: there is not exactly one, and none was named.
    """
    names = [station.station for station in told.stations]
    members = {"stations": names}
    if name is None:
        if len(told.stations) == 1:
            return told.stations[0]
        detail = f"This server has several stations: {', '.join(names)}."
        raise WhichStationError("which-station", 404, detail, _PATH, None, members)
    for station in told.stations:
        if station.station == name:
            return station
    detail = f"There is no station {name!r}; there is {', '.join(names)}."
    raise UnknownStationError("unknown-station", 404, detail, _PATH, None, members)


def asset_of(station: StationInfo) -> str:
    """The asset that is assembled at a station.

    Raises:
        NoAssetError: none, or it is not known yet.
    """
    if station.facts is None:
        raise NoAssetError(
            f"Station {station.station} has not opened its source yet: "
            f"{station.worker.message}. Try again."
        )
    if station.facts.asset is None:
        raise NoAssetError(f"Station {station.station} tracks loose parts: they have no models.")
    return station.facts.asset
