"""What `snapfit benchmark --clutter` does: what do detectors find in cluttered images?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from snapfit.models.bop_writer import write_text
from snapfit.models.errors import DatasetError, SnapfitError
from snapfit.models.train_labels import SET_NAME, TRAIN
from snapfit.server.cli.benchmark_files import check_writable, put_into
from snapfit.tracking.benchmark.clutter import Tally, check_can_detect, judge_images
from snapfit.tracking.benchmark.clutter_report import (
    clutter_json,
    clutter_lines,
    clutter_markdown,
)
from snapfit.tracking.benchmark.provenance import commit
from snapfit.tracking.errors import TrackingError


def run_clutter(
    data: Path,
    out: Path,
    methods: Sequence[str],
    assets: Sequence[str] = (),
    page: Path | None = None,
) -> None:
    """Judges methods on all sets; writes `clutter.md` and `clutter.json`.

    Args:
        data: a dataset with the split of training images, of another seed than theirs.
        out: folder for results.
        methods: names.
        assets: only these; all if empty.
        page: where the report is to be put in, too.

    Raises:
        SnapfitError: no such set or method; or, when all the rest is written, what could not be
            run.
    """
    console = Console(highlight=False)
    check_can_detect(methods)
    folders = _sets(data, assets)
    check_writable(out)
    # That of the code that is loaded, whatever is changed meanwhile.
    loaded = commit()
    tallies: list[Tally] = []
    problems: list[str] = []
    columns = (TextColumn("{task.description}"), BarColumn())
    with Progress(*columns, TaskProgressColumn(), TimeElapsedColumn(), console=console) as bar:
        task = bar.add_task("", total=float(len(folders) * len(methods)))
        runs = [(method, folder) for method in methods for folder in folders]
        for number, (method, folder) in enumerate(runs):

            def show(message: str, share: float, done: int = number) -> None:
                bar.update(task, description=message, completed=done + share)

            try:
                tallies.append(judge_images(folder, folder.name, method, show))
            except SnapfitError as error:
                problems.append(f"{folder.name}: {method}: {error}")
            bar.update(task, completed=number + 1)
    if tallies:
        text = clutter_markdown(tallies, loaded, problems, _note(folders))
        write_text(out / "clutter.md", text)
        record = json.dumps(clutter_json(tallies, loaded), indent=1, allow_nan=False)
        write_text(out / "clutter.json", record + "\n")
        if page is not None:
            write_text(page, put_into(page, text))
        for line in clutter_lines(tallies):
            console.print(line, soft_wrap=True)
        console.print(f"written to {out}", soft_wrap=True)
    if problems:
        raise TrackingError(f"{len(problems)} runs are missing: {'; '.join(problems)}")


def _sets(data: Path, assets: Sequence[str]) -> list[Path]:
    """The folders of the assets that have a finished set."""
    found = sorted(path.parents[1] for path in data.glob(f"*/{TRAIN}/{SET_NAME}"))
    kept = [each for each in found if not assets or each.name in assets]
    if not kept:
        asked = f" of {', '.join(assets)}" if assets else ""
        problem = f"holds no images{asked}: snapfit dataset render --split train --seed 21 --depth"
        raise DatasetError(data, problem)
    return kept


def _note(folders: Sequence[Path]) -> str:
    """What the sets say of themselves, each remark once."""
    notes: dict[str, None] = {}
    for folder in folders:
        record = json.loads((folder / TRAIN / SET_NAME).read_text(encoding="utf-8"))
        notes[str(record.get("note", ""))] = None
    return "; ".join(note for note in notes if note)
