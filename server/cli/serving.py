"""`snapfit demo` and `snapfit serve`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from snapfit.server.cli.errors import clear_errors
from snapfit.server.cli.progress import StartProgress
from snapfit.server.run import run_server
from snapfit.server.settings import Settings, load_settings, make_settings, with_station
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
) -> None:
    """Track the simulated bench and serve its poses."""
    with clear_errors():
        settings = make_settings("the environment", {})
        station = {"source": DEMO_SOURCE, "asset": asset}
        _serve(settings, host, port, {**station, **_given(detector, provider, record)})


def serve(
    config: Annotated[Path, typer.Option(help="The settings.")] = Path("snapfit.toml"),
    host: _Host = None,
    port: _Port = None,
    detector: _Detector = None,
    provider: _Providers = None,
    record: _Record = None,
) -> None:
    """Track a station and serve its poses."""
    with clear_errors():
        _serve(load_settings(config), host, port, _given(detector, provider, record))


def _given(
    detector: str | None, providers: list[str] | None, record: Path | None
) -> dict[str, Any]:
    return {
        **({} if record is None else {"record": str(record)}),
        **({} if detector is None else {"detector": detector}),
        **({"providers": providers} if providers else {}),
    }


def _serve(settings: Settings, host: str | None, port: int | None, station: dict[str, Any]) -> None:
    given = {"host": host, "port": port}
    update = {key: value for key, value in given.items() if value is not None}
    settings = with_station(settings.model_copy(update=update), station)
    run_server(settings, StartProgress(settings, Console()).follow)
