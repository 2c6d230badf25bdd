"""The stations of a server, by name."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from http import HTTPStatus

from snapfit.server.asset_library import ExportedAsset
from snapfit.server.clock import Clock
from snapfit.server.fleet.keepers import Back, back_here
from snapfit.server.problems import ProblemError
from snapfit.server.settings import StationSettings
from snapfit.server.station import Station


class Stations:
    """All stations; empty until they are opened.

    Args:
        settings: one for each station.
        clock: the server's time line.
        pipeline: "module:function" that opens source and tracker in the workers.
        back: makes what stands behind a station.
    """

    def __init__(
        self,
        settings: list[StationSettings],
        clock: Clock,
        pipeline: str,
        back: Back = back_here,
    ) -> None:
        self.clock = clock
        self._settings = settings
        self._pipeline = pipeline
        self._back = back
        self._stations: dict[str, Station] = {}

    def open(self) -> None:
        """Make the stores and start the workers."""
        for settings in self._settings:
            station = Station(settings, self.clock, self._pipeline, self._back)
            self._stations[settings.name] = station
            station.start()

    def close(self) -> None:
        """End the workers and remove the stores."""
        while self._stations:
            _, station = self._stations.popitem()
            station.close()

    @asynccontextmanager
    async def watched(self) -> AsyncIterator[None]:
        """While it is open, whoever waits for a snapshot is woken."""
        tasks = [asyncio.create_task(station.watch.run()) for station in self]
        for task in tasks:
            task.add_done_callback(_log_failure)
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    def end_streams(self) -> None:
        """Let long polls and streams end now, because the server does."""
        for station in self:
            station.watch.end()

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

    def assets(self) -> list[tuple[ExportedAsset, list[str]]]:
        """What is assembled here, and the names of the stations at which."""
        found: dict[ExportedAsset, list[str]] = {}
        for station in self:
            asset = station.asset()
            if asset is not None:
                found.setdefault(asset, []).append(station.name)
        return list(found.items())

    def asset(self, name: str) -> ExportedAsset:
        """The asset of this name.

        Raises:
            ProblemError: 404; lists the assets that there are.
        """
        known = {asset.info.asset: asset for asset, _ in self.assets()}
        if name not in known:
            names = list(known)
            told = f"there is {', '.join(names)}" if names else "there is none yet"
            raise ProblemError(
                HTTPStatus.NOT_FOUND,
                "unknown-asset",
                f"No station of this server assembles {name!r}; {told}.",
                assets=names,
            )
        return known[name]

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


def _log_failure(task: asyncio.Task[None]) -> None:
    if not task.cancelled() and task.exception() is not None:
        _LOG.critical("long polls and streams wait in vain now", exc_info=task.exception())


_LOG = logging.getLogger(__name__)
_PREFIX, _SUFFIX = "/v1/stations/", "/poses"
