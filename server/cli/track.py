"""`snapfit track`: the tracker on a recording, without a server."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli import options
from snapfit.server.cli.errors import clear_errors


def track(
    sequence: Annotated[
        Path,
        typer.Argument(
            help="Folder of a recorded sequence or of a BOP scene, or an MCAP recording."
        ),
    ],
    asset: Annotated[
        str | None,
        typer.Option(help="Bundled asset, or its folder, in place of the recording's parts."),
    ] = None,
    method: Annotated[str, typer.Option(help="Tracking method.")] = "icg",
    detector: Annotated[
        str | None,
        typer.Option(
            help="Finds the parts in place of the recording's first poses, and again where they "
            "are lost: geometric (their shape in the depth image) or network (the asset's own)."
        ),
    ] = None,
    provider: options.Providers = None,
    out: options.PoseLines = None,
    video: options.Film = None,
) -> None:
    """Track the parts of a recording, and say how well it went where the truth is known."""
    with clear_errors():
        # The tracker's libraries take seconds to load, and --help needs none of them.
        from snapfit.server.cli.track_run import Finding, run

        finding = Finding(detector, tuple(provider or ("cpu",)))
        run(sequence, asset=asset, method=method, finding=finding, out=out, video=video)
