"""`snapfit key`: who may ask a server that others can reach."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from snapfit.server.cli.errors import clear_errors
from snapfit.server.security.first_key import key_file
from snapfit.server.security.key_file import add_key, read_keys, remove_key
from snapfit.server.security.roles import Role
from snapfit.server.settings import load_settings, make_settings

_USUAL_CONFIG = Path("snapfit.toml")

key_app = typer.Typer(no_args_is_help=True, help="API keys: add, list, remove.")

_Config = Annotated[
    Path | None,
    typer.Option(help="The server's settings, which name the key file; snapfit.toml if it is."),
]


@key_app.command()
def add(
    name: Annotated[str, typer.Argument(help="Who it is for.")],
    role: Annotated[Role, typer.Option(help="What it is good for.")] = Role.READ,
    config: _Config = None,
) -> None:
    """Make a key. It is shown this once; the file has only its hash."""
    with clear_errors():
        path = _file(config)
        key = add_key(path, name, role)
    typer.echo(key)
    typer.echo(f"{name} ({role}), hash in {path}", err=True)


@key_app.command("list")
def list_keys(config: _Config = None) -> None:
    """Show names, ids and roles of the keys."""
    with clear_errors():
        path = _file(config)
        table = read_keys(path)
    if table is None or not table.keys:
        typer.echo(f"no keys in {path}")
        return
    shown = Table("name", "id", "role", "made", box=None)
    for record in table.keys:
        shown.add_row(record.name, record.id, record.role, record.created_at)
    Console(highlight=False).print(shown)


@key_app.command()
def remove(
    name: Annotated[str, typer.Argument(help="Name or id of the key.")],
    config: _Config = None,
) -> None:
    """Remove a key; a running server refuses it, its sessions and its streams within a second."""
    with clear_errors():
        path = _file(config)
        remove_key(path, name)
    typer.echo(f"removed {name}", err=True)


def _file(config: Path | None) -> Path:
    if config is None and not _USUAL_CONFIG.is_file():
        return key_file(make_settings("the environment", {}).security)
    return key_file(load_settings(config or _USUAL_CONFIG).security)
