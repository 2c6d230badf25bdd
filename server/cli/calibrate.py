"""`snapfit calibrate`: a board to print, and a camera file from its images."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.cli.errors import clear_errors

calibrate_app = typer.Typer(
    name="calibrate", help="Calibrate a camera that brings no calibration.", no_args_is_help=True
)

_Columns = Annotated[int, typer.Option(help="Squares of the board, across.")]
_Rows = Annotated[int, typer.Option(help="Squares of the board, down.")]
_Square = Annotated[float, typer.Option(help="Side of a square on paper, mm: measure it.")]


@calibrate_app.command()
def board(
    out: Annotated[Path, typer.Argument(help="The file to write, .pdf or .png.")],
    columns: _Columns = 9,
    rows: _Rows = 6,
    square_mm: _Square = 28.0,
) -> None:
    """Write the board for printing; the default fits on A4 and on US letter."""
    with clear_errors():
        # OpenCV takes a while to load, and --help does not need it.
        from snapfit.models.charuco import CharucoBoard, write_board

        made = CharucoBoard(columns, rows, square_mm)
        write_board(out, made)
    typer.echo(f"{made} in {out}: print it at 100 % and glue it onto something flat")


@calibrate_app.command()
def camera(
    source: Annotated[
        str, typer.Argument(help="Folder with images of the board, or a camera such as uvc:0.")
    ],
    out: Annotated[Path, typer.Option(help="The camera file to write, JSON.")] = Path(
        "camera.json"
    ),
    columns: _Columns = 9,
    rows: _Rows = 6,
    square_mm: _Square = 28.0,
    views: Annotated[
        int, typer.Option(min=10, max=200, help="Of a camera: so many views are taken.")
    ] = 25,
) -> None:
    """Calibrate a camera from images of the board, and write its camera file."""
    with clear_errors():
        # OpenCV takes a while to load, and --help does not need it.
        from snapfit.models.charuco import CharucoBoard
        from snapfit.server.cli.calibrate_run import run

        run(source, out, CharucoBoard(columns, rows, square_mm), views)
