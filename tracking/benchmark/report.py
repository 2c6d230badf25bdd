"""The benchmark's figures as Markdown and JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from snapfit.models.gbot_dataset import PAPER_CONDITIONS
from snapfit.tracking.benchmark.benchmark import Outcome
from snapfit.tracking.benchmark.scores import Score, mean_score, part_scores, run_score
from snapfit.tracking.metrics import MOST_VERTICES

_BUSY = 0.5
"""Load beyond the number of cores from which on times are marked."""

Column = tuple[str, Callable[[Score], str]]

MEANING = f"""\
Every row starts from the true poses of its first frame, which counts as any other. A frame \
without an estimate is a failure: beyond every threshold, 10 cm in e_trans, 180 degrees in e_rot, \
infinite in medians. ADD is taken of parts without symmetry, ADD-S of symmetric ones, over the \
mesh's vertices (of more than {MOST_VERTICES} a fixed sample of {MOST_VERTICES}, seed 0); MSSD and \
MSPD over all vertices. A row is the mean over all parts and frames; the means are over rows.

- **ADD(-S)**: the GBOT paper's score at 10 cm, mean of max(1 - e / 10 cm, 0), %; **< 10 cm**: \
frames under 10 cm, %; **e_trans**: cm; **e_rot**: degrees, parts without symmetry; **ms**: \
tracking of a frame with all its parts, mean, reading of images left out.
- **< 0.1 d**: frames whose ADD(-S) is under 10 % of the part's diameter, %; **AUC 2 cm**: area \
under the curve of ADD(-S) up to 2 cm, %; **AR MSSD**, **AR MSPD**: BOP's average recalls, %; \
**MSSD**, **MSPD**: medians, mm and px; **lost**: frames without an estimate, %; **state**: frames \
with the true assembly state, %; **switch**: mean delay of a noticed switch of state, frames, \
negative is early; **missed**: switches not noticed before the next one, %."""


def _column(title: str, name: str, digits: int = 1) -> Column:
    return title, lambda score: _number(getattr(score, name), digits)


PAPER_COLUMNS = (
    _column("ADD(-S)", "add_score"),
    _column("< 10 cm", "under_10_cm"),
    _column("e_trans", "translation_cm", 2),
    _column("e_rot", "rotation_deg"),
    _column("ms", "time_ms"),
)
STRICT_COLUMNS = (
    _column("< 0.1 d", "add_recall"),
    _column("AUC 2 cm", "add_auc"),
    _column("AR MSSD", "mssd_recall"),
    _column("AR MSPD", "mspd_recall"),
    _column("MSSD", "mssd_mm", 2),
    _column("MSPD", "mspd_px", 2),
    _column("lost", "lost"),
    _column("state", "state_accuracy"),
    _column("switch", "switch_delay"),
    _column("missed", "switches_missed"),
)


@dataclass(frozen=True)
class Provenance:
    """What makes the figures again.

    Attributes:
        command: as it was typed.
        most_frames: of each sequence; None for all.
        note: what the dataset says of itself (seed), or nothing.
    """

    command: str
    most_frames: int | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Row:
    """A line of the tables.

    Attributes:
        asset, condition, method: what it is of.
        score: its figures.
    """

    asset: str
    condition: str
    method: str
    score: Score


def rows_of(outcomes: Sequence[Outcome]) -> list[Row]:
    """A row for each outcome, in their order."""
    return [
        Row(each.run.asset, each.run.condition, each.run.method, run_score(each.run))
        for each in outcomes
    ]


def overall(rows: Sequence[Row]) -> list[Row]:
    """Means by method: over the paper's four conditions; `all` and others each apart."""
    means = []
    for method in dict.fromkeys(row.method for row in rows):
        own = [row for row in rows if row.method == method]
        groups = {"overall": [row for row in own if row.condition in PAPER_CONDITIONS]}
        for row in own:
            if row.condition not in PAPER_CONDITIONS:
                groups.setdefault(row.condition, []).append(row)
        for name, group in groups.items():
            if group:
                means.append(Row("mean", name, method, mean_score([row.score for row in group])))
    return means


def markdown(outcomes: Sequence[Outcome], provenance: Provenance) -> str:
    """The whole report."""
    rows = rows_of(outcomes)
    means = overall(rows) if len(rows) > 1 else []
    blocks = [
        "# Benchmark",
        "\n".join(f"- {line}" for line in _facts(outcomes, provenance)),
        "## As in the paper",
        _table([*rows, *means], PAPER_COLUMNS),
        "## Strict",
        _table([*rows, *means], STRICT_COLUMNS),
        "## By part",
        _part_table(outcomes),
        "## What the figures mean",
        MEANING,
    ]
    return "\n\n".join(blocks) + "\n"


def as_json(outcomes: Sequence[Outcome], provenance: Provenance) -> dict[str, Any]:
    """The same for programs; None where there is no answer or it is infinite."""
    rows = rows_of(outcomes)
    return {
        "provenance": asdict(provenance),
        "rows": [
            {
                **_row_record(row),
                "n_frames": len(each.run.frames),
                "parts": {name: _record(score) for name, score in part_scores(each.run).items()},
                "circumstances": asdict(each.circumstances),
                "run": each.path.name,
            }
            for row, each in zip(rows, outcomes, strict=True)
        ],
        "means": [_row_record(row) for row in overall(rows)],
    }


def _facts(outcomes: Sequence[Outcome], provenance: Provenance) -> Iterator[str]:
    yield f"Command: `{provenance.command}`"
    commits = dict.fromkeys(each.circumstances.commit for each in outcomes)
    yield f"Commit: {', '.join(commits)} (+: with changes)"
    for machine in dict.fromkeys(each.circumstances.machine for each in outcomes):
        yield f"Machine: {machine.cpu}, {machine.n_cores} cores; {machine.system}"
    yield f"Data: {provenance.note or 'says nothing of its seed'}"
    n_frames = sum(len(each.run.frames) for each in outcomes)
    limit = provenance.most_frames
    some = f", the first {limit} of each sequence: a quick look, no result" if limit else ""
    yield f"Frames: {n_frames}{some}"
    n_jobs = max((each.circumstances.n_jobs for each in outcomes), default=1)
    if n_jobs > 1:
        yield f"**Times are not to be trusted: {n_jobs} sequences ran side by side**"
    else:
        yield "Times: one sequence at a time"
    busy = max((each.circumstances.load or 0.0) - _n_cores(each) for each in outcomes)
    if busy > _BUSY:
        yield f"**Times are too long: {busy:.1f} more processes than cores wanted to run**"


def _n_cores(outcome: Outcome) -> int:
    return outcome.circumstances.machine.n_cores


def _table(rows: Sequence[Row], columns: Sequence[Column]) -> str:
    titles = ["asset", "condition", "method", *(title for title, _ in columns)]
    lines = [titles, ["---"] * 3 + ["---:"] * len(columns)]
    for row in rows:
        names = [row.asset, row.condition, row.method]
        lines.append([*names, *(show(row.score) for _, show in columns)])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _part_table(outcomes: Sequence[Outcome]) -> str:
    columns = [*PAPER_COLUMNS[:-1], *STRICT_COLUMNS[:-3]]
    titles = ["asset", "condition", "method", "part", *(title for title, _ in columns)]
    lines = [titles, ["---"] * 4 + ["---:"] * len(columns)]
    for each in outcomes:
        run = each.run
        for name, is_symmetric, score in zip(
            run.parts, run.symmetric, part_scores(run).values(), strict=True
        ):
            title = f"{name} (s)" if is_symmetric else name
            cells = [show(score) for _, show in columns]
            lines.append([run.asset, run.condition, run.method, title, *cells])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _row_record(row: Row) -> dict[str, Any]:
    names = {"asset": row.asset, "condition": row.condition, "method": row.method}
    return names | {"score": _record(row.score)}


def _record(score: Score) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in asdict(score).items()}


def _number(value: float, digits: int) -> str:
    if math.isnan(value):
        return "-"
    return "∞" if math.isinf(value) else f"{value:.{digits}f}"
