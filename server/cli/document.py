"""`snapfit openapi`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.app import create_app
from snapfit.server.cli.errors import clear_errors
from snapfit.server.settings import make_settings


def openapi(
    out: Annotated[Path | None, typer.Option(help="File to write; else standard output.")] = None,
) -> None:
    """Write the OpenAPI document of the API."""
    with clear_errors():
        app = create_app(make_settings("the environment", {}))
    document = json.dumps(app.openapi(), indent=2) + "\n"
    if out is None:
        typer.echo(document, nl=False)
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(document, encoding="utf-8")
