"""What `snapfit export` does."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from rich.console import Console

from snapfit.models.asset import find_asset
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.rerun_export import write_rerun


def run(recording: Path, out: Path, asset: str | None) -> None:
    """Writes one file.

    Raises:
        SnapfitError: of any room; the command line shows it as one line.
    """
    console = Console(highlight=False)
    given = None if asset is None else find_asset(asset)
    with closing(OpenRecording(recording)) as opened:
        if opened.problem is not None:
            told = f"[yellow]note[/yellow] {recording} {opened.problem}"
            console.print(told, soft_wrap=True)
        n_frames = write_rerun(opened, out, given)
    console.print(f"{n_frames} frames in {out}", soft_wrap=True)
