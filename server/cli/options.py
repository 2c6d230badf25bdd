"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from snapfit.server.logs.setup import LogFormat

Config = Annotated[Path, typer.Option(help="The settings.")]
DEFAULT_CONFIG = Path("snapfit.toml")

Host = Annotated[str | None, typer.Option(help="Address to listen at; 0.0.0.0 for all.")]
Port = Annotated[int | None, typer.Option(min=1, max=65535, help="Port to listen at.")]
TlsCert = Annotated[str | None, typer.Option(help="Certificate chain, PEM: HTTPS.")]
TlsKey = Annotated[str | None, typer.Option(help="The certificate's private key, PEM.")]
LogFormatOption = Annotated[LogFormat | None, typer.Option(help="How logs are written.")]

Detector = Annotated[
    str | None,
    typer.Option(help="What finds the parts: auto, network, geometric, or none."),
]
Providers = Annotated[
    list[str] | None,
    typer.Option(
        "--provider",
        help="What runs the network: cpu, cuda, tensorrt, coreml, directml; several times, the "
        "first choice first.",
    ),
]
Record = Annotated[
    Path | None,
    typer.Option(help="Folder to record into what the station sees and says (MCAP)."),
]

PoseLines = Annotated[
    Path | None, typer.Option(help="Write a line of JSON for each frame and part.")
]
Film = Annotated[
    Path | None, typer.Option(help="Write an MP4 with the parts drawn into the image.")
]
