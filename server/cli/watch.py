"""`snapfit watch`: poses and assembly of a station, live in a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli.errors import clear_errors
from snapfit.server.conventions import Convention
from snapfit.server.errors import WatchError


def watch(
    url: Annotated[str, typer.Argument(help="The server's address.")] = "http://127.0.0.1:8000",
    station: Annotated[
        str | None, typer.Option(help="The station, where the server has several.")
    ] = None,
    key: Annotated[str | None, typer.Option(envvar="SNAPFIT_KEY", help="API key.")] = None,
    convention: Annotated[
        Convention, typer.Option(help="Axes that poses are given in.")
    ] = Convention.OPENCV,
    frame: Annotated[
        str, typer.Option(help="Frame that poses are given in: camera, or anchor:ID.")
    ] = "camera",
    ca: Annotated[
        Path | None, typer.Option(help="Certificate to trust over HTTPS, PEM.", dir_okay=False)
    ] = None,
    once: Annotated[
        bool,
        typer.Option("--once", help="Show one snapshot and end: exit code 1 if it is stale."),
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Write each snapshot as a line of JSON.")
    ] = False,
) -> None:
    """Show a station's poses, assembly and events as they come; a line a second into a pipe."""
    with clear_errors():
        if ca is not None and not ca.is_file():
            raise WatchError(f"{ca}: no such file")
        # The client's libraries take a while to load, and --help needs none of them.
        from snapfit.server.cli.watch_run import WatchOptions, run

        verify = True if ca is None else str(ca)
        options = WatchOptions(
            url, station, key, verify, str(convention), frame, once=once, as_json=as_json
        )
        is_fresh = run(options)
    if not is_fresh:
        raise typer.Exit(1)
