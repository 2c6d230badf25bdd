"""What `snapfit benchmark` does: finds, runs, writes, shows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from snapfit.models.sequence import SEQUENCE_NAME
from snapfit.server.cli.video import VideoFile
from snapfit.tracking.benchmark.benchmark import (
    QUICK_FRAMES,
    Outcome,
    Task,
    check_methods,
    run_tasks,
)
from snapfit.tracking.benchmark.plots import can_plot, plot_errors
from snapfit.tracking.benchmark.provenance import command_line
from snapfit.tracking.benchmark.report import (
    PAPER_COLUMNS,
    STRICT_COLUMNS,
    Provenance,
    as_json,
    markdown,
    overall,
    rows_of,
)
from snapfit.tracking.benchmark.sequences import SequenceFolder, find_sequences, open_sequence
from snapfit.tracking.benchmark.side_by_side import panel_camera, pictures
from snapfit.tracking.errors import SourceError

_SHOWN = ("< 0.1 d", "lost")
"""Of the strict figures, those that fit into a terminal."""

_SUMMARY_WIDTH = 110


@dataclass(frozen=True)
class Wishes:
    """The command's options.

    Attributes:
        data: dataset or sequence.
        out: folder for results.
        methods: names.
        assets, conditions: only these; all if empty.
        quick: the first frames alone.
        n_jobs: tasks side by side.
        films: whether to make them.
    """

    data: Path
    out: Path
    methods: tuple[str, ...]
    assets: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()
    quick: bool = False
    n_jobs: int = 1
    films: bool = True


def run(wishes: Wishes) -> None:
    """Runs what is not finished yet, then writes every result.

    Raises:
        SnapfitError: of any room; the command line shows it as one line.
    """
    console = Console(highlight=False)
    check_methods(wishes.methods)
    folders = find_sequences(wishes.data, wishes.assets, wishes.conditions)
    most_frames = QUICK_FRAMES if wishes.quick else None
    for each in folders:
        open_sequence(each, most_frames)  # What is incomplete is told before hours have passed.
    tasks = [Task(each, method, most_frames) for each in folders for method in wishes.methods]
    outcomes = _run(tasks, wishes, console)
    provenance = Provenance(command_line(), most_frames, _note(folders))
    _write(wishes.out / "benchmark.md", markdown(outcomes, provenance))
    record = json.dumps(as_json(outcomes, provenance), indent=2, allow_nan=False)
    _write(wishes.out / "benchmark.json", record + "\n")
    _plot(outcomes, wishes.out, console)
    if wishes.films:
        _film(outcomes, wishes.out, console)
    # In a narrow terminal long lines are folded, which is better than names cut off.
    wide = Console(highlight=False, width=max(console.width, _SUMMARY_WIDTH))
    wide.print(_summary(outcomes))
    console.print(f"written to {wishes.out}", soft_wrap=True)


def _run(tasks: Sequence[Task], wishes: Wishes, console: Console) -> list[Outcome]:
    """All outcomes in the order of the tasks."""
    done: dict[Task, Outcome] = {}
    with _bar(console) as bar:
        whole = bar.add_task("sequences", total=len(tasks))
        current = bar.add_task("", total=1.0, visible=wishes.n_jobs == 1)

        def show(message: str, share: float) -> None:
            bar.update(current, description=message, completed=share)

        for outcome in run_tasks(tasks, wishes.out / "runs", wishes.n_jobs, show):
            done[outcome.task] = outcome
            bar.update(whole, completed=len(done))
            if not outcome.is_new:
                bar.console.print(f"[dim]finished before: {outcome.task.name}[/dim]")
    return [done[task] for task in tasks]


def _bar(console: Console) -> Progress:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    return Progress(*columns, console=console, transient=True)


def _plot(outcomes: Sequence[Outcome], out: Path, console: Console) -> None:
    if not can_plot():
        hint = "no plots: pip install 'snapfit[benchmark]' brings matplotlib"
        console.print(hint, style="yellow", markup=False)
        return
    for asset in dict.fromkeys(each.run.asset for each in outcomes):
        runs = [each.run for each in outcomes if each.run.asset == asset]
        plot_errors(runs, out / f"{asset}.png")


def _film(outcomes: Sequence[Outcome], out: Path, console: Console) -> None:
    """A film of each sequence; one that is newer than its runs is left as it is."""
    folder = out / "films"
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise SourceError(f"{folder}: cannot be made: {error.strerror}") from error
    sequences: dict[SequenceFolder, list[Outcome]] = {}
    for each in outcomes:
        sequences.setdefault(each.task.folder, []).append(each)
    with _bar(console) as bar:
        task = bar.add_task("films", total=len(sequences))
        for sequence, own in sequences.items():
            path = folder / f"{sequence.name}.mp4"
            newest = max(each.path.stat().st_mtime for each in own)
            if not path.is_file() or path.stat().st_mtime < newest:
                _film_sequence(path, sequence, own)
            bar.advance(task)


def _film_sequence(path: Path, sequence: SequenceFolder, own: Sequence[Outcome]) -> None:
    recording = open_sequence(sequence, own[0].task.most_frames)
    camera = panel_camera(recording.camera.color)
    size_px = (camera.width * (1 + len(own)), camera.height)
    draft = path.with_name(f".{path.name}")
    with closing(VideoFile(draft, recording.frame_rate_hz, size_px)) as film:
        for picture in pictures(recording, [each.run for each in own]):
            film.add(picture)
    draft.replace(path)


def _note(folders: Sequence[SequenceFolder]) -> str:
    """What the sequences say of themselves, each remark once."""
    notes: dict[str, None] = {}
    for folder in folders:
        path = folder.directory / SEQUENCE_NAME
        if path.is_file():
            content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            notes[str(content.get("note", ""))] = None
    return "; ".join(note for note in notes if note)


def _summary(outcomes: Sequence[Outcome]) -> Table:
    rows = rows_of(outcomes)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("asset", "condition", "method"):
        table.add_column(title, no_wrap=True)
    columns = [*PAPER_COLUMNS, *(each for each in STRICT_COLUMNS if each[0] in _SHOWN)]
    for title, _ in columns:
        table.add_column(title, justify="right", no_wrap=True)
    for row in [*rows, *(overall(rows) if len(rows) > 1 else [])]:
        cells = [show(row.score) for _, show in columns]
        table.add_row(row.asset, row.condition, row.method, *cells)
    return table


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}") from error
