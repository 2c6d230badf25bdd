"""What `snapfit benchmark --recovery` does: how soon are all parts tracked (again)?"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from snapfit.models.bop_writer import write_text
from snapfit.models.errors import SnapfitError
from snapfit.server.cli.benchmark_files import check_writable, put_into
from snapfit.tracking.benchmark.provenance import commit
from snapfit.tracking.benchmark.recovery import Recovered, check_can_recover, run_trials
from snapfit.tracking.benchmark.recovery_report import (
    recovery_json,
    recovery_lines,
    recovery_markdown,
)
from snapfit.tracking.benchmark.sequences import SequenceFolder, find_sequences, open_sequence
from snapfit.tracking.errors import TrackingError

_Result = tuple[list[Recovered], list[str]]


@dataclass(frozen=True)
class RecoveryWishes:
    """The command's options.

    Attributes:
        data: dataset or sequence.
        out: folder for results.
        methods: names.
        assets, conditions: only these; all if empty.
        n_jobs: sequences side by side.
        page: where the report is to be put in, too.
    """

    data: Path
    out: Path
    methods: tuple[str, ...]
    assets: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()
    n_jobs: int = 1
    page: Path | None = None


def run_recovery(wishes: RecoveryWishes) -> None:
    """Tries all methods on all sequences; writes `recovery.md` and `recovery.json`.

    Raises:
        SnapfitError: no such sequence or method; or, when all the rest is written, what could not
            be run.
    """
    console = Console(highlight=False)
    check_can_recover(wishes.methods)
    folders = find_sequences(wishes.data, wishes.assets, wishes.conditions)
    check_writable(wishes.out)
    # That of the code that is loaded, whatever is changed meanwhile.
    loaded = commit()
    results: list[Recovered] = []
    problems: list[str] = []
    columns = (TextColumn("{task.description}"), BarColumn())
    with Progress(*columns, TaskProgressColumn(), TimeElapsedColumn(), console=console) as bar:
        task = bar.add_task("sequences", total=len(folders))
        for found, wrong in _sequences(folders, wishes):
            results += found
            problems += wrong
            bar.advance(task)
    if not results:
        raise TrackingError(f"nothing could be run: {'; '.join(dict.fromkeys(problems))}")
    order = list(folders)
    names = [(each.asset, each.condition) for each in order]
    results.sort(
        key=lambda each: (
            wishes.methods.index(each.method),
            names.index((each.asset, each.condition)),
        )
    )
    told = list(dict.fromkeys(problems))
    text = recovery_markdown(results, loaded, told)
    write_text(wishes.out / "recovery.md", text)
    record = _finite(recovery_json(results, loaded))
    write_text(wishes.out / "recovery.json", json.dumps(record, indent=1, allow_nan=False) + "\n")
    if wishes.page is not None:
        write_text(wishes.page, put_into(wishes.page, text))
    for line in recovery_lines(results):
        console.print(line, soft_wrap=True)
    console.print(f"written to {wishes.out}", soft_wrap=True)
    if told:
        raise TrackingError(f"{len(told)} runs are missing: {'; '.join(told)}")


def _sequences(folders: Sequence[SequenceFolder], wishes: RecoveryWishes) -> Iterable[_Result]:
    if wishes.n_jobs == 1:
        return (_sequence(folder, wishes.methods) for folder in folders)
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=wishes.n_jobs, return_as="generator_unordered", batch_size=1)
    done: Iterable[_Result] = parallel(
        delayed(_sequence)(folder, wishes.methods) for folder in folders
    )
    return done


def _sequence(folder: SequenceFolder, methods: Sequence[str]) -> _Result:
    """What came of a sequence, and what could not be run."""
    try:
        results, problems = run_trials(folder, open_sequence(folder), methods)
    except SnapfitError as error:
        return [], [f"{folder.name}: {error}"]
    # An asset without a network has none under any condition: it is told once.
    return results, [f"{folder.asset}: {name}: {error}" for name, error in problems.items()]


def _finite(value: Any) -> Any:
    """Infinity, a trial without end, is null for programs."""
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
