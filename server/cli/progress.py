"""What the terminal shows while a server starts: the worker's progress, then the address."""

from __future__ import annotations

import asyncio

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from snapfit.server.errors import WorkerRefusedError
from snapfit.server.security.first_key import reachable_host
from snapfit.server.security.tls import uses_tls
from snapfit.server.settings import Settings
from snapfit.server.station import Station
from snapfit.server.stations import Stations

_PERIOD_S = 0.1
_ANY_HOST = ("0.0.0.0", "::")  # noqa: S104


class StartProgress:
    """Shows the progress of the workers until every station serves its first poses."""

    def __init__(self, settings: Settings, console: Console) -> None:
        self._settings = settings
        self._console = console

    async def follow(self, stations: Stations) -> None:
        """Runs beside the server; ends with the first poses.

        Raises:
            WorkerRefusedError: a worker was refused by a file or a setting.
        """
        self._console.print(
            f"[dim]starting; {base_url(self._settings)} shows the progress too[/dim]"
        )
        while not list(stations):
            await asyncio.sleep(_PERIOD_S)
        for station in stations:
            await self._follow_station(station)
        self._announce()

    async def _follow_station(self, station: Station) -> None:
        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TimeElapsedColumn(),
        )
        said = ""
        with Progress(*columns, console=self._console, transient=True) as bar:
            task = bar.add_task("starting", total=None)
            while not station.is_ready():
                worker = station.info().worker
                if station.is_refused:
                    raise WorkerRefusedError(worker.message)
                if worker.message != said:
                    said = worker.message
                    bar.reset(task, description=said)
                    if not self._console.is_terminal:
                        self._console.print(said)
                total = None if worker.progress is None else 1.0
                bar.update(task, total=total, completed=worker.progress or 0.0)
                await asyncio.sleep(_PERIOD_S)

    def _announce(self) -> None:
        address = base_url(self._settings)
        self._console.print(f"[bold green]tracking[/bold green]  {address}")
        self._console.print(f"  page   {address}/", highlight=False)
        self._console.print(f"  poses  curl {address}/v1/poses", highlight=False)
        self._console.print("  Ctrl-C ends it.", highlight=False)


def base_url(settings: Settings, *, outside: bool = False) -> str:
    """Where the server can be asked: from this machine, or from `outside` of it."""
    host = settings.host
    if host in _ANY_HOST:
        host = reachable_host(host) if outside else "127.0.0.1"
    scheme = "https" if uses_tls(settings.security) else "http"
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{settings.port}"
