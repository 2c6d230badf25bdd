"""`snapfit anchor`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from pydantic import ValidationError

from snapfit.server.boards import CharucoBoard, MarkerDictionary, QrCode
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


class Kind(StrEnum):
    """What is printed."""

    CHARUCO = "charuco"
    QR = "qr"


@anchor_app.callback()
def _anchor() -> None:
    """Align a headset's world with the camera."""


@anchor_app.command()
def board(
    out: Annotated[Path, typer.Option(help="The PDF to write.")] = Path("board.pdf"),
    paper: Annotated[Paper, typer.Option(help="What it is printed on.")] = Paper.A4,
    kind: Annotated[
        Kind, typer.Option(help="A ChArUco board, the most exact, or a QR code.")
    ] = Kind.CHARUCO,
    columns: Annotated[int, typer.Option(help="charuco: squares from left to right.")] = 5,
    rows: Annotated[int, typer.Option(help="charuco: squares from top to bottom.")] = 7,
    square_mm: Annotated[float, typer.Option(help="charuco: edge of a square.")] = 35.0,
    marker_mm: Annotated[float, typer.Option(help="charuco: edge of a marker.")] = 26.0,
    dictionary: Annotated[
        MarkerDictionary, typer.Option(help="charuco: OpenCV's dictionary of markers.")
    ] = MarkerDictionary.DICT_5X5_100,
    text: Annotated[str, typer.Option(help="qr: what it says; short is seen best.")] = "snapfit",
    size_mm: Annotated[float, typer.Option(help="qr: edge of the code.")] = 150.0,
) -> None:
    """Write a board that camera and headset can both see, to be printed at 100 %."""
    with clear_errors():
        from snapfit.server.board_pdf import board_pdf  # OpenCV takes a moment to load

        wanted: CharucoBoard | QrCode
        try:
            if kind is Kind.QR:
                wanted = QrCode(kind="qr", text=text, size_m=size_mm / 1e3)
            else:
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
    typer.echo(f"put anchors with this board: {wanted.model_dump_json()}")
