"""`snapfit replay`: tracks a station's recording again, and says whether it came out the same."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli import options
from snapfit.server.cli.errors import clear_errors


def replay(
    recording: Annotated[Path, typer.Argument(help="A station's recording, an MCAP file.")],
    asset: Annotated[
        str | None,
        typer.Option(help="The asset that was tracked, where it lies elsewhere now."),
    ] = None,
    out: options.PoseLines = None,
    video: options.Film = None,
) -> None:
    """Track a recording again, with what the detector found then, and compare the poses."""
    with clear_errors():
        # The tracker's libraries take seconds to load, and --help needs none of them.
        from snapfit.server.cli.replay_run import run

        is_as_expected = run(recording, asset=asset, out=out, video=video)
    if not is_as_expected:
        raise typer.Exit(1)
