"""What `snapfit benchmark` does: finds, runs, writes, shows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from snapfit.models.errors import SnapfitError
from snapfit.models.sequence import SEQUENCE_NAME
from snapfit.server.cli.benchmark_files import check_writable, write_films, write_results
from snapfit.tracking.benchmark.benchmark import Failure, Outcome, Plan, Task, run_tasks
from snapfit.tracking.benchmark.provenance import command_line
from snapfit.tracking.benchmark.quick import QUICK_FRAMES, quick_dataset
from snapfit.tracking.benchmark.report import Provenance
from snapfit.tracking.benchmark.roster import check_methods
from snapfit.tracking.benchmark.sequences import SequenceFolder, find_sequences, open_sequence
from snapfit.tracking.benchmark.tables import PAPER_COLUMNS, STRICT_COLUMNS, overall, rows_of
from snapfit.tracking.errors import TrackingError

_SHOWN = ("< 0.1 d", "lost")
"""Of the strict figures, those that fit into a terminal."""

_SUMMARY_WIDTH = 110


@dataclass(frozen=True)
class Wishes:
    """The command's options.

    Attributes:
        data: dataset or sequence; None for the small one of a quick benchmark.
        out: folder for results.
        methods: names.
        assets, conditions: only these; all if empty.
        quick: the first frames alone.
        n_jobs: sequences side by side.
        films: whether to make them.
        any_commit: whether finished runs of other versions of the code stand.
        page: where the report is to be put in, too.
    """

    data: Path | None
    out: Path
    methods: tuple[str, ...]
    assets: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()
    quick: bool = False
    n_jobs: int = 1
    films: bool = True
    any_commit: bool = False
    page: Path | None = None


def run(wishes: Wishes) -> None:
    """Runs what is not finished yet, then writes every result.

    Raises:
        SnapfitError: of any room; the command line shows it as one line. What could not be run is
            told when all the rest is written.
    """
    console = Console(highlight=False)
    check_methods(wishes.methods)
    data = _data(wishes, console)
    folders = find_sequences(data, wishes.assets, wishes.conditions)
    check_writable(wishes.out)
    most_frames = QUICK_FRAMES if wishes.quick else None
    tasks, refused = _tasks(folders, wishes.methods, most_frames, console)
    outcomes, failures = _run(tasks, wishes, console)
    failures += refused
    order = {(each, m): None for each in folders for m in wishes.methods}
    outcomes.sort(key=lambda each: list(order).index((each.folder, each.method)))
    if not outcomes:
        raise TrackingError(f"nothing could be run: {_told(failures)}")
    provenance = Provenance(command_line(), most_frames, _note(folders))
    write_results(wishes.out, wishes.page, outcomes, provenance, failures, console)
    if wishes.films:
        with _bar(console) as bar:
            write_films(outcomes, most_frames, wishes.out / "films", bar)
    # In a narrow terminal long lines are folded, which is better than names cut off.
    wide = Console(highlight=False, width=max(console.width, _SUMMARY_WIDTH))
    wide.print(_summary(outcomes))
    console.print(f"written to {wishes.out}", soft_wrap=True)
    if failures:
        raise TrackingError(f"{len(failures)} runs are missing: {_told(failures)}")


def _data(wishes: Wishes, console: Console) -> Path:
    if wishes.data is not None:
        return wishes.data
    if not wishes.quick:
        raise TrackingError("--data is missing: name a dataset; only --quick brings its own")
    with _bar(console) as bar:
        task = bar.add_task("", total=1.0)
        return quick_dataset(
            lambda message, share: bar.update(task, description=message, completed=share)
        )


def _tasks(
    folders: Sequence[SequenceFolder],
    methods: tuple[str, ...],
    most_frames: int | None,
    console: Console,
) -> tuple[list[Task], list[Failure]]:
    """Tasks, the longest first, and what is refused: told now, before hours have passed."""
    lengths: dict[Task, int] = {}
    refused: list[Failure] = []
    for each in folders:
        try:
            recording = open_sequence(each, most_frames)
        except SnapfitError as error:
            console.print(f"left out: {each.name}: {error}", style="red", soft_wrap=True)
            refused += [Failure(each, method, str(error)) for method in methods]
        else:
            # With processes side by side, none is left alone with a long one in the end.
            length = len(recording.frames) * len(recording.parts)
            lengths[Task(each, methods, most_frames)] = length
    return sorted(lengths, key=lambda task: -lengths[task]), refused


def _run(
    tasks: Sequence[Task], wishes: Wishes, console: Console
) -> tuple[list[Outcome], list[Failure]]:
    """What came of the tasks, as it was finished."""
    outcomes: list[Outcome] = []
    failures: list[Failure] = []
    plan = Plan.of(wishes.methods, wishes.out / "runs", wishes.n_jobs, any_code=wishes.any_commit)
    with _bar(console) as bar:
        whole = bar.add_task("runs", total=len(tasks) * len(wishes.methods))
        current = bar.add_task("", total=1.0, visible=wishes.n_jobs == 1)

        def show(message: str, share: float) -> None:
            bar.update(current, description=message, completed=share)

        for each in run_tasks(tasks, plan, show):
            name = f"{each.folder.name}: {each.method}"
            if isinstance(each, Failure):
                failures.append(each)
                bar.console.print(f"failed: {name}: {each.problem}", style="red", soft_wrap=True)
            else:
                outcomes.append(each)
                if not each.is_new:
                    bar.console.print(f"[dim]finished before: {name}[/dim]")
            bar.update(whole, completed=len(outcomes) + len(failures))
    return outcomes, failures


def _bar(console: Console) -> Progress:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    return Progress(*columns, console=console, transient=True)


def _told(failures: Sequence[Failure]) -> str:
    """What is wrong, each problem once."""
    problems = dict.fromkeys(f"{each.folder.name}: {each.problem}" for each in failures)
    return "; ".join(problems)


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
