"""Rows and columns of the benchmark's tables, and tables as Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from snapfit.models.gbot_dataset import PAPER_CONDITIONS
from snapfit.tracking.benchmark.benchmark import Outcome
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.scores import Score, mean_score, run_score
from snapfit.tracking.benchmark.sequences import condition_order

Column = tuple[str, Callable[[Score], str]]

MEAN = "mean"
OVERALL = "overall"
TOLD = "†"
"""Follows the name of a method that is told the true state of each frame."""


def number(value: float, digits: int) -> str:
    """For a cell; a dash where there is no answer."""
    if math.isnan(value):
        return "-"
    return "∞" if math.isinf(value) else f"{value:.{digits}f}"


def _column(title: str, name: str, digits: int = 1) -> Column:
    return title, lambda score: number(getattr(score, name), digits)


_RECALL = _column("< 0.1 d", "add_recall")
_SETTLED = _column("settled", "settled_accuracy")
_FOUND = _column("found", "switches_found")

PAPER_COLUMNS = (
    _column("ADD(-S)", "add_score"),
    _column("< 10 cm", "under_10_cm"),
    _column("e_trans", "translation_cm", 2),
    _column("e_rot", "rotation_deg"),
    _column("ms", "time_ms"),
)
STRICT_COLUMNS = (
    _RECALL,
    _column("AUC 2 cm", "add_auc"),
    _column("AR MSSD", "mssd_recall"),
    _column("AR MSPD", "mspd_recall"),
    _column("MSSD", "mssd_mm", 2),
    _column("MSPD", "mspd_px", 2),
    _column("lost", "lost"),
    _column("CPU ms", "cpu_ms"),
)
STATE_COLUMNS = (
    _column("state", "state_accuracy"),
    _SETTLED,
    _FOUND,
    _column("missed", "switches_missed"),
    _column("switch", "switch_delay"),
    _column("beyond", "switches_beyond"),
    _column("alarms", "alarms"),
)
ABLATION_COLUMNS = (*PAPER_COLUMNS[:-1], *STRICT_COLUMNS[:2], _SETTLED, _FOUND)


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
        Row(each.run.asset, each.run.condition, method_title(each.run), run_score(each.run))
        for each in outcomes
    ]


def method_title(run: Run) -> str:
    """The method's name, marked if it was told the true states."""
    return run.method + (TOLD if run.is_told_state else "")


def overall(rows: Sequence[Row]) -> list[Row]:
    """Means by method: over the paper's four conditions; `all` and others each apart."""
    paper = [row for row in rows if row.condition in PAPER_CONDITIONS]
    others = [row for row in rows if row.condition not in PAPER_CONDITIONS]
    return [*_means(paper, lambda _: OVERALL), *by_condition(others)]


def by_condition(rows: Sequence[Row]) -> list[Row]:
    """Means over the assets, by condition and method."""
    ordered = sorted(rows, key=lambda row: condition_order(row.condition))
    return _means(ordered, lambda row: row.condition)


def table(
    rows: Sequence[Row], columns: Sequence[Column], names: Sequence[str] = ("condition", "method")
) -> str:
    """A table in Markdown.

    Args:
        rows: its lines.
        columns: figures.
        names: attributes of a row that come first.
    """
    cells = [
        [*(getattr(row, name) for name in names), *(show(row.score) for _, show in columns)]
        for row in rows
    ]
    return plain_table([*names, *(title for title, _ in columns)], cells, len(names))


def plain_table(titles: Sequence[str], cells: Sequence[Sequence[str]], n_names: int) -> str:
    """A table in Markdown, of texts; all but the first columns are figures."""
    rule = ["---"] * n_names + ["---:"] * (len(titles) - n_names)
    return "\n".join("| " + " | ".join(line) + " |" for line in (titles, rule, *cells))


def _means(rows: Sequence[Row], group_of: Callable[[Row], str]) -> list[Row]:
    groups: dict[tuple[str, str], list[Score]] = {}
    for row in rows:
        groups.setdefault((group_of(row), row.method), []).append(row.score)
    return [
        Row(MEAN, group, method, mean_score(scores)) for (group, method), scores in groups.items()
    ]
