"""`snapfit asset check`: is a bundle fit to be tracked, what is in it, what does it look like?

`snapfit asset arlem`: its steps for players of the standard ARLEM.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from snapfit.server.cli.errors import clear_errors

if TYPE_CHECKING:
    from snapfit.models.asset import Asset

GRAPH_NAME, EXPLODED_NAME = "graph.mmd", "exploded.png"

asset_app = typer.Typer(no_args_is_help=True, help="Assets: parts, assembly graph, steps.")


@asset_app.command()
def check(
    directory: Annotated[
        Path, typer.Argument(help="Folder with asset.toml, or the name of a bundled asset.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the assembly graph (Mermaid) and an exploded view (PNG)."),
    ] = None,
) -> None:
    """Check a bundle: manifest, meshes, units, assembly graph. Exit code 1 if it is refused."""
    with clear_errors(exit_code=1):
        from snapfit.models.asset import find_asset

        asset = find_asset(directory)
    console = Console(highlight=False)
    console.print(f"[bold]{asset.title}[/bold] ({asset.name}), {asset.licence}")
    console.print(_part_table(asset))
    if asset.states:
        console.print(_state_table(asset))
    if asset.steps:
        console.print(_step_table(asset))
        # Plain, so that it can be pasted where Mermaid is drawn.
        typer.echo(mermaid(asset))
    if out is not None:
        with clear_errors(exit_code=1):
            draw(asset, out)
        console.print(f"drawn: {out / GRAPH_NAME}, {out / EXPLODED_NAME}", soft_wrap=True)


@asset_app.command()
def arlem(
    directory: Annotated[
        Path, typer.Argument(help="Folder with asset.toml, or the name of a bundled asset.")
    ],
    out: Annotated[
        Path, typer.Option(help="Folder for ASSET-workplace.json and ASSET-activity.json.")
    ],
    server: Annotated[
        str, typer.Option(help="The snapfit that serves meshes and assembly, as players reach it.")
    ] = "http://127.0.0.1:8000",
    station: Annotated[
        str | None, typer.Option(help="Whose assembly is followed, where a server has several.")
    ] = None,
    language: Annotated[str, typer.Option(help="Language of the texts, ISO 639-1.")] = "en",
) -> None:
    """Write the steps as ARLEM (IEEE 1589-2020): a workplace and an activity model."""
    with clear_errors(exit_code=1):
        from snapfit.models.asset import find_asset
        from snapfit.server.arlem.files import write_arlem
        from snapfit.server.asset_export import asset_info

        written = write_arlem(asset_info(find_asset(directory)), out, server, station, language)
    for path in written:
        typer.echo(f"written: {path}")


def draw(asset: Asset, folder: Path) -> None:
    """Writes the assembly graph, `graph.mmd`, and the exploded view, `exploded.png`.

    Raises:
        PictureError: the folder cannot be made, or a file not be written.
    """
    import cv2

    from snapfit.models.errors import PictureError
    from snapfit.models.exploded_view import exploded_view

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = f"the folder cannot be made ({error.strerror}): choose another --out"
        raise PictureError(folder, problem) from error
    picture = cv2.imencode(".png", exploded_view(asset).image)[1].tobytes()
    for name, content in ((GRAPH_NAME, f"{mermaid(asset)}\n".encode()), (EXPLODED_NAME, picture)):
        try:
            (folder / name).write_bytes(content)
        except OSError as error:
            problem = f"cannot be written ({error.strerror}): choose another --out"
            raise PictureError(folder / name, problem) from error


def mermaid(asset: Asset) -> str:
    """The assembly graph in the language of Mermaid: states as nodes, steps as arrows."""
    ids = {state.name: f"s{i}" for i, state in enumerate(asset.states)}
    lines = ["graph TD"]
    lines += [f'    {ids[state.name]}["{state.name}"]' for state in asset.states]
    lines += [
        f'    {ids[step.from_state]} -->|"{step.name}"| {ids[step.to_state]}'
        for step in asset.steps
    ]
    return "\n".join(lines)


def _part_table(asset: Asset) -> Table:
    from snapfit.models.mesh import count_open_edges

    table = Table("part", "class", "size mm", "faces", "closed", "symmetry", "tracked")
    for part in asset.parts:
        size_mm = (part.mesh.vertices.max(axis=0) - part.mesh.vertices.min(axis=0)) * 1000
        n_open = count_open_edges(part.mesh.faces)
        table.add_row(
            part.name,
            str(part.class_id),
            " x ".join(f"{length:.1f}" for length in size_mm),
            str(len(part.mesh.faces)),
            "yes" if n_open == 0 else f"no, {n_open} open edges",
            part.symmetry.kind,
            "yes" if part.tracked else "no",
        )
    return table


def _state_table(asset: Asset) -> Table:
    table = Table("state", "links", "tolerances", "decides")
    for state in asset.states:
        links = state.links
        table.add_row(
            state.name,
            "\n".join(f"{each.parent} <- {each.child} ({each.joint.type})" for each in links),
            "\n".join(
                f"{each.translation_tolerance_m * 1000:g} mm, {each.rotation_tolerance_deg:g} deg"
                for each in links
            ),
            "\n".join("yes" if each.decides_switch else "no" for each in links),
        )
    return table


def _step_table(asset: Asset) -> Table:
    table = Table("step", "from", "to", "parts", "title")
    for step in asset.steps:
        table.add_row(step.name, step.from_state, step.to_state, ", ".join(step.parts), step.title)
    return table
