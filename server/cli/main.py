"""The `snapfit` command."""

from __future__ import annotations

from importlib.metadata import version
from typing import Annotated

import typer

from snapfit.server.cli.anchor import anchor_app
from snapfit.server.cli.asset import asset_app
from snapfit.server.cli.benchmark import benchmark
from snapfit.server.cli.calibrate import calibrate_app
from snapfit.server.cli.dataset import dataset_app
from snapfit.server.cli.document import openapi
from snapfit.server.cli.export import export
from snapfit.server.cli.key import key_app
from snapfit.server.cli.record import record
from snapfit.server.cli.replay import replay
from snapfit.server.cli.serving import demo, serve
from snapfit.server.cli.track import track
from snapfit.server.cli.train import train
from snapfit.server.cli.watch import watch
from snapfit.server.cli.worker import worker

app = typer.Typer(
    name="snapfit",
    help="6D poses of parts on a workbench, over HTTP.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (
    demo,
    serve,
    watch,
    worker,
    track,
    record,
    replay,
    export,
    benchmark,
    train,
    openapi,
):
    app.command()(command)
app.add_typer(anchor_app, name="anchor")
app.add_typer(asset_app, name="asset")
app.add_typer(calibrate_app, name="calibrate")
app.add_typer(dataset_app, name="dataset")
app.add_typer(key_app, name="key")


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
    """Run the command line."""
    app()
