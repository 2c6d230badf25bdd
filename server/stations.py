"""The stations of a server, by name."""

from __future__ import annotations

from collections.abc import Iterator
from http import HTTPStatus

from snapfit.server.clock import Clock
from snapfit.server.fleet.keepers import MakeKeeper, keep_here
from snapfit.server.problems import ProblemError
from snapfit.server.settings import StationSettings
from snapfit.server.station import Station


class Stations:
    """All stations; empty until they are opened.

    Args:
        settings: one for each station.
        clock: the server's time line.
        pipeline: "module:function" that opens source and tracker in the workers.
        make_keeper: makes who keeps the workers running.
    """

    def __init__(
        self,
        settings: list[StationSettings],
        clock: Clock,
        pipeline: str,
        make_keeper: MakeKeeper = keep_here,
    ) -> None:
        self.clock = clock
        self._settings = settings
        self._pipeline = pipeline
        self._make_keeper = make_keeper
        self._stations: dict[str, Station] = {}

    def open(self) -> None:
        """Make the stores and start the workers."""
        for settings in self._settings:
            station = Station(settings, self.clock, self._pipeline, self._make_keeper)
            self._stations[settings.name] = station
            station.start()

    def close(self) -> None:
        """End the workers and remove the stores."""
        while self._stations:
            _, station = self._stations.popitem()
            station.close()

    def __iter__(self) -> Iterator[Station]:
        return iter(self._stations.values())

    def named(self, name: str) -> Station:
        """The station of this name.

        Raises:
            ProblemError: 404; lists the stations that exist.
        """
        station = self._stations.get(name)
        if station is None:
            names = list(self._stations)
            raise ProblemError(
                HTTPStatus.NOT_FOUND,
                "unknown-station",
                f"There is no station {name!r}; there is {', '.join(names)}.",
                stations=names,
            )
        return station

    def only(self) -> Station:
        """The one station, for the short forms of the paths.

        Raises:
            ProblemError: 404 where there are several; lists them.
        """
        if len(self._stations) == 1:
            return next(iter(self._stations.values()))
        names = list(self._stations)
        raise ProblemError(
            HTTPStatus.NOT_FOUND,
            "which-station",
            f"This server has several stations: ask for /v1/stations/NAME/..., NAME one of "
            f"{', '.join(names)}; /v1/stations tells of all.",
            stations=names,
        )

    def at_poses_path(self, path: str) -> Station | None:
        """The station whose poses are at this path, long or short; None elsewhere."""
        if path == "/v1/poses":
            return next(iter(self._stations.values())) if len(self._stations) == 1 else None
        if path.startswith(_PREFIX) and path.endswith(_SUFFIX):
            return self._stations.get(path[len(_PREFIX) : -len(_SUFFIX)])
        return None


_PREFIX, _SUFFIX = "/v1/stations/", "/poses"
