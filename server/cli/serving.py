"""`snapfit demo` and `snapfit serve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from snapfit.server.cli import options
from snapfit.server.cli.errors import clear_errors
from snapfit.server.cli.progress import StartProgress, base_url
from snapfit.server.errors import SettingsError
from snapfit.server.fleet.keepers import MEMORY
from snapfit.server.run import run_server
from snapfit.server.security.first_key import first_key, key_file, show_first_key
from snapfit.server.settings import (
    Settings,
    load_settings,
    make_settings,
    with_security,
    with_station,
)
from snapfit.server.worker_spec import DEMO_SOURCE

DEFAULT_ASSET = "hobby-corner-clamp"


def demo(
    asset: Annotated[str, typer.Option(help="A bundled asset, or its folder.")] = DEFAULT_ASSET,
    host: options.Host = None,
    port: options.Port = None,
    detector: options.Detector = None,
    provider: options.Providers = None,
    record: options.Record = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
    log_format: options.LogFormatOption = None,
) -> None:
    """Track the simulated bench and serve its poses."""
    with clear_errors():
        settings = make_settings("the environment", {})
        if settings.store != MEMORY:
            problem = "store: the demo tracks and serves in one: unset SNAPFIT_STORE"
            raise SettingsError("the environment", [problem])
        station = {"source": DEMO_SOURCE, "asset": asset}
        settings = with_station(settings, {**station, **_finding(detector, provider, record)})
        settings = with_security(settings, _given(tls_cert=tls_cert, tls_key=tls_key))
        _serve(settings.model_copy(update=_given(host=host, port=port, log_format=log_format)))


def serve(
    config: options.Config = options.DEFAULT_CONFIG,
    host: options.Host = None,
    port: options.Port = None,
    detector: options.Detector = None,
    provider: options.Providers = None,
    record: options.Record = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
    log_format: options.LogFormatOption = None,
) -> None:
    """Track a station and serve its poses."""
    with clear_errors():
        settings = with_station(load_settings(config), _finding(detector, provider, record))
        settings = with_security(settings, _given(tls_cert=tls_cert, tls_key=tls_key))
        _serve(settings.model_copy(update=_given(host=host, port=port, log_format=log_format)))


def _finding(
    detector: str | None, providers: list[str] | None, record: Path | None
) -> dict[str, Any]:
    folder = None if record is None else str(record)
    return _given(detector=detector, providers=providers or None, record=folder)


def _given(**given: Any) -> dict[str, Any]:
    """The options that were given on the command line."""
    return {name: value for name, value in given.items() if value is not None}


def _serve(settings: Settings) -> None:
    console = Console()
    key = first_key(settings.security, settings.host)
    if key is not None:
        show_first_key(console, key, base_url(settings, outside=True), key_file(settings.security))
    run_server(settings, StartProgress(settings, console).follow)
