"""`snapfit export`: a station's recording for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli.errors import clear_errors


def export(
    recording: Annotated[Path, typer.Argument(help="A station's recording, an MCAP file.")],
    rerun: Annotated[
        Path, typer.Option(help="Write a file for the Rerun viewer, .rrd (extra rerun).")
    ],
    asset: Annotated[
        str | None,
        typer.Option(help="The asset that was tracked, where it lies elsewhere now."),
    ] = None,
) -> None:
    """Write a recording as a file for the Rerun viewer: images, depth, parts, confidences, log."""
    with clear_errors():
        # OpenCV and the libraries of recordings take a while to load; --help needs none of them.
        from snapfit.server.cli.export_run import run

        run(recording, rerun, asset)
