"""`snapfit record`: the frames of a source, without tracking and without a server."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from snapfit.server.cli.errors import clear_errors


def record(
    source: Annotated[
        str, typer.Argument(help="A camera's address, or a recording, as in station.source.")
    ],
    out: Annotated[Path, typer.Option(help="The file to write, MCAP.")],
    asset: Annotated[
        str | None, typer.Option(help="The asset under assembly: a bundled one, or its folder.")
    ] = None,
    calibration: Annotated[
        Path | None, typer.Option(help="Camera file of a USB or network camera.")
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(min=0.1, help="For so long; without it until Ctrl-C.")
    ] = None,
    color: Annotated[
        Literal["png", "jpeg"],
        typer.Option(help="png loses nothing; jpeg takes a tenth of the room."),
    ] = "png",
) -> None:
    """Record the frames of a camera, to be tracked later with `snapfit track`."""
    with clear_errors():
        # OpenCV and the libraries of recordings take a while to load; --help needs none of them.
        from snapfit.server.cli.record_run import run

        run(source, out, asset=asset, calibration=calibration, seconds=seconds, color=color)
