"""The files that `snapfit benchmark` writes: report, figures, plots, films."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from snapfit.server.cli.video import VideoFile
from snapfit.tracking.benchmark.benchmark import Failure, Outcome
from snapfit.tracking.benchmark.groups import calibrations
from snapfit.tracking.benchmark.plots import can_plot, plot_assets
from snapfit.tracking.benchmark.record import as_json
from snapfit.tracking.benchmark.reliability_plot import plot_reliability
from snapfit.tracking.benchmark.report import Provenance, markdown, parts_markdown
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence
from snapfit.tracking.benchmark.side_by_side import panel_camera, picture_size_px, pictures
from snapfit.tracking.errors import SourceError

BEGIN, END = "<!-- benchmark -->", "<!-- /benchmark -->"
"""Between these lines of a page the report is put; a page without them is written whole."""


def check_writable(folder: Path) -> None:
    """Makes the folder for results and tries it, before anything is run.

    Raises:
        SourceError: it cannot be made or written in.
    """
    probe = folder / ".probe"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        problem = f"{error.strerror}; choose another --out"
        raise SourceError(f"{folder}: results cannot be written there: {problem}") from error


def write_results(
    out: Path,
    page: Path | None,
    outcomes: Sequence[Outcome],
    provenance: Provenance,
    failures: Sequence[Failure],
    console: Console,
) -> None:
    """Writes `benchmark.md`, `parts.md`, `benchmark.json` and the plots.

    Raises:
        SourceError: a file cannot be written.
    """
    text = markdown(outcomes, provenance, failures)
    _write(out / "benchmark.md", text)
    _write(out / "parts.md", parts_markdown(outcomes))
    record = json.dumps(as_json(outcomes, provenance, failures), indent=2, allow_nan=False)
    _write(out / "benchmark.json", record + "\n")
    if page is not None:
        _write(page, put_into(page, text))
    if can_plot():
        plot_assets([each.run for each in outcomes], out)
        plot_reliability(calibrations(outcomes), out / "reliability.png")
    else:
        hint = "no plots: pip install 'snapfit[benchmark]' brings matplotlib"
        console.print(hint, style="yellow", markup=False)


def write_films(
    outcomes: Sequence[Outcome], most_frames: int | None, folder: Path, bar: Progress
) -> None:
    """A film of each sequence; one that is newer than its runs is left as it is.

    Raises:
        SourceError: one cannot be written.
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise SourceError(f"{folder}: cannot be made: {error.strerror}") from error
    sequences: dict[SequenceFolder, list[Outcome]] = {}
    for each in outcomes:
        sequences.setdefault(each.folder, []).append(each)
    task = bar.add_task("films", total=len(sequences))
    for sequence, own in sequences.items():
        path = folder / f"{sequence.name}.mp4"
        newest = max(each.path.stat().st_mtime for each in own)
        if not path.is_file() or path.stat().st_mtime < newest:
            _film(path, sequence, most_frames, own)
        bar.advance(task)


def _film(
    path: Path, sequence: SequenceFolder, most_frames: int | None, own: Sequence[Outcome]
) -> None:
    recording = open_sequence(sequence, most_frames)
    size_px = picture_size_px(panel_camera(recording.camera.color), len(own))
    draft = path.with_name(f".{path.name}")
    with closing(VideoFile(draft, recording.frame_rate_hz, size_px)) as film:
        for picture in pictures(recording, [each.run for each in own]):
            film.add(picture)
    draft.replace(path)


def put_into(page: Path, text: str) -> str:
    """The page with the report between its two marks; the report alone where there are none."""
    if not page.is_file():
        return text
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        return text
    body = text.partition("\n")[2].strip()  # The page has a title of its own.
    return f"{before}{BEGIN}\n\n{body}\n\n{END}{after}"


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}") from error
