"""`snapfit worker`: track here, serve elsewhere."""

from __future__ import annotations

from typing import Annotated

import typer

from snapfit.server.cli import options
from snapfit.server.cli.errors import clear_errors
from snapfit.server.errors import SettingsError
from snapfit.server.fleet.host import run_workers
from snapfit.server.fleet.keepers import MEMORY
from snapfit.server.settings import Settings, load_settings


def worker(
    config: options.Config = options.DEFAULT_CONFIG,
    station: Annotated[
        list[str] | None,
        typer.Option(help="A station to track; several times for several. All, if none is named."),
    ] = None,
    log_format: options.LogFormatOption = None,
) -> None:
    """Track stations and publish them on Redis or Valkey, for servers on any machine."""
    with clear_errors():
        settings = _chosen(load_settings(config), station)
        if settings.store == MEMORY:
            problem = "store: is 'memory', which no other machine can read: set a redis:// address"
            raise SettingsError(config, [problem])
        if log_format is not None:
            settings = settings.model_copy(update={"log_format": log_format})
        run_workers(settings, typer.echo)


def _chosen(settings: Settings, names: list[str] | None) -> Settings:
    if not names:
        return settings
    known = {station.name: station for station in settings.all_stations}
    unknown = [name for name in names if name not in known]
    if unknown:
        problem = f"no station {', '.join(unknown)} in the settings; there is {', '.join(known)}"
        raise SettingsError("--station", [problem])
    return settings.model_copy(update={"stations": tuple(known[name] for name in names)})
