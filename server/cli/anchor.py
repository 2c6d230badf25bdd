"""`snapfit anchor`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from pydantic import ValidationError

from snapfit.server.boards import CharucoBoard, MarkerDictionary
from snapfit.server.cli.errors import clear_errors
from snapfit.server.errors import BoardError

anchor_app = typer.Typer(
    help="Align a headset's world with the camera.", no_args_is_help=True, add_completion=False
)


class Paper(StrEnum):
    """What is printed on."""

    A4 = "a4"
    A3 = "a3"
    LETTER = "letter"


@anchor_app.callback()
def _anchor() -> None:
    """Align a headset's world with the camera."""


@anchor_app.command()
def board(
    out: Annotated[Path, typer.Option(help="The PDF to write.")] = Path("board.pdf"),
    paper: Annotated[Paper, typer.Option(help="What it is printed on.")] = Paper.A4,
    columns: Annotated[int, typer.Option(help="Squares from left to right.")] = 5,
    rows: Annotated[int, typer.Option(help="Squares from top to bottom.")] = 7,
    square_mm: Annotated[float, typer.Option(help="Edge of a square.")] = 35.0,
    marker_mm: Annotated[float, typer.Option(help="Edge of a marker.")] = 26.0,
    dictionary: Annotated[
        MarkerDictionary, typer.Option(help="OpenCV's dictionary of markers.")
    ] = MarkerDictionary.DICT_5X5_100,
) -> None:
    """Write a ChArUco board that camera and headset can both see, to be printed at 100 %."""
    with clear_errors():
        from snapfit.server.board_pdf import board_pdf  # OpenCV takes a moment to load

        try:
            wanted = CharucoBoard(
                columns=columns,
                rows=rows,
                square_m=square_mm / 1e3,
                marker_m=marker_mm / 1e3,
                dictionary=dictionary,
            )
        except ValidationError as error:
            told = [": ".join([*map(str, each["loc"]), each["msg"]]) for each in error.errors()]
            raise BoardError("; ".join(told)) from error
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_bytes(board_pdf(wanted, paper))
    typer.echo(f"{out}: print it at 100 % and measure the ruler: 100 mm from end to end")
