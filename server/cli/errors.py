"""Errors on the command line: one clear line, and an exit code."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.text import Text

from snapfit.models.errors import SnapfitError


@contextmanager
def clear_errors(exit_code: int = 2) -> Iterator[None]:
    """Shows every error that snapfit raises on purpose without a traceback, on standard error."""
    try:
        yield
    except SnapfitError as error:
        # No wrapping: a path that is cut in two cannot be copied.
        line = Text.assemble(("error: ", "bold red"), str(error))
        Console(stderr=True, soft_wrap=True, highlight=False).print(line)
        raise typer.Exit(exit_code) from error
