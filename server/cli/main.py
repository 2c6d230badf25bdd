"""The `snapfit` command."""

from __future__ import annotations

import sys
from importlib.metadata import version
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from snapfit.models.errors import SnapfitError
from snapfit.server.cli.document import openapi
from snapfit.server.cli.serving import demo, serve
from snapfit.server.errors import AddressError, PortInUseError, SettingsError

_FAILED, _MISUSED = 1, 2
_MISUSES = (AddressError, PortInUseError, SettingsError)

app = typer.Typer(
    name="snapfit",
    help="6D poses of parts on a workbench, over HTTP.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(demo)
app.command()(serve)
app.command()(openapi)


def _show_version(value: bool) -> None:
    if value:
        typer.echo(f"snapfit {version('snapfit')}")
        raise typer.Exit


@app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    del show_version  # answered by its callback


def main() -> None:
    """Run the command line; an error of ours is a line or two on standard error."""
    try:
        app()
    except SnapfitError as error:
        console = Console(stderr=True, soft_wrap=True)
        console.print(Text.assemble(("snapfit: ", "bold red"), str(error)))
        sys.exit(_MISUSED if isinstance(error, _MISUSES) else _FAILED)
