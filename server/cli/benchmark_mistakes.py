"""What `snapfit benchmark --mistakes` does: are wrong parts noticed, and how soon?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from snapfit.models.bop_writer import write_text
from snapfit.models.errors import SnapfitError
from snapfit.models.workbench.mistake import find_mistakes
from snapfit.server.cli.benchmark_files import check_writable
from snapfit.tracking.benchmark.mistakes import Verdict, check_can_judge, judge_mistake
from snapfit.tracking.benchmark.mistakes_report import (
    mistakes_json,
    mistakes_markdown,
    summary_line,
)
from snapfit.tracking.benchmark.provenance import commit
from snapfit.tracking.errors import TrackingError


def run_mistakes(data: Path, out: Path, methods: Sequence[str], assets: Sequence[str] = ()) -> None:
    """Judges all sequences by all methods; writes `mistakes.md` and `mistakes.json`.

    Args:
        data: a dataset with the split of mistakes.
        out: folder for results.
        methods: names.
        assets: only these; all if empty.

    Raises:
        SnapfitError: no such sequence or method; or, when all the rest is written, what could not
            be run.
    """
    console = Console(highlight=False)
    check_can_judge(methods)
    check_writable(out)
    # That of the code that is loaded, whatever is changed meanwhile.
    loaded = commit()
    folders = [each for each in find_mistakes(data) if not assets or each.asset in assets]
    if not folders:
        raise TrackingError(f"{data} has no mistakes of {', '.join(assets)}")
    verdicts: list[Verdict] = []
    problems: list[str] = []
    columns = (TextColumn("{task.description}"), BarColumn())
    with Progress(*columns, TaskProgressColumn(), TimeElapsedColumn(), console=console) as bar:
        task = bar.add_task("", total=len(folders) * len(methods))
        for folder in folders:
            for method in methods:
                bar.update(task, description=f"{folder.asset} {folder.directory.name} {method}")
                try:
                    verdicts.append(judge_mistake(folder, method))
                except SnapfitError as error:
                    problems.append(str(error))
                bar.advance(task)
    if verdicts:
        verdicts.sort(key=lambda each: list(methods).index(each.method))
        write_text(out / "mistakes.md", mistakes_markdown(verdicts, loaded))
        write_text(
            out / "mistakes.json", json.dumps(mistakes_json(verdicts, loaded), indent=1) + "\n"
        )
        for line in summary_line(verdicts):
            console.print(line, soft_wrap=True)
        console.print(f"written to {out}", soft_wrap=True)
    if problems:
        raise TrackingError(f"{len(problems)} runs are missing: {'; '.join(problems)}")
