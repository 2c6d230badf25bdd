"""`snapfit demo` and `snapfit serve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from snapfit.server.cli.errors import clear_errors
from snapfit.server.cli.progress import StartProgress, base_url
from snapfit.server.errors import SettingsError
from snapfit.server.fleet.keepers import MEMORY
from snapfit.server.logs.setup import LogFormat
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

_Host = Annotated[str | None, typer.Option(help="Address to listen at; 0.0.0.0 for all.")]
_Port = Annotated[int | None, typer.Option(min=1, max=65535, help="Port to listen at.")]
_Detector = Annotated[
    str | None,
    typer.Option(help="What finds the parts: auto, network, geometric, or none."),
]
_Providers = Annotated[
    list[str] | None,
    typer.Option(
        "--provider",
        help="What runs the network: cpu, cuda, tensorrt, coreml, directml; several times, the "
        "first choice first.",
    ),
]


_TlsCert = Annotated[str | None, typer.Option(help="Certificate chain, PEM: HTTPS.")]
_TlsKey = Annotated[str | None, typer.Option(help="The certificate's private key, PEM.")]

_LogFormat = Annotated[LogFormat | None, typer.Option(help="How logs are written.")]
_Record = Annotated[
    Path | None,
    typer.Option(help="Folder to record into what the station sees and says (MCAP)."),
]


def demo(
    asset: Annotated[str, typer.Option(help="A bundled asset, or its folder.")] = DEFAULT_ASSET,
    host: _Host = None,
    port: _Port = None,
    detector: _Detector = None,
    provider: _Providers = None,
    record: _Record = None,
    tls_cert: _TlsCert = None,
    tls_key: _TlsKey = None,
    log_format: _LogFormat = None,
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
    config: Annotated[Path, typer.Option(help="The settings.")] = Path("snapfit.toml"),
    host: _Host = None,
    port: _Port = None,
    detector: _Detector = None,
    provider: _Providers = None,
    record: _Record = None,
    tls_cert: _TlsCert = None,
    tls_key: _TlsKey = None,
    log_format: _LogFormat = None,
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


def _given(**options: Any) -> dict[str, Any]:
    """The options that were given on the command line."""
    return {name: value for name, value in options.items() if value is not None}


def _serve(settings: Settings) -> None:
    console = Console()
    key = first_key(settings.security, settings.host)
    if key is not None:
        show_first_key(console, key, base_url(settings, outside=True), key_file(settings.security))
    run_server(settings, StartProgress(settings, console).follow)
