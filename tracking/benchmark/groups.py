"""Outcomes of a benchmark by method and condition."""

from __future__ import annotations

from collections.abc import Sequence

from snapfit.models.gbot_dataset import PAPER_CONDITIONS
from snapfit.tracking.benchmark.benchmark import Outcome
from snapfit.tracking.benchmark.calibration import Calibration, calibration
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.sequences import condition_order
from snapfit.tracking.benchmark.tables import OVERALL


def methods_of(outcomes: Sequence[Outcome]) -> list[str]:
    """Names of methods, each once."""
    return list(dict.fromkeys(each.method for each in outcomes))


def by_method(outcomes: Sequence[Outcome]) -> dict[str, list[Run]]:
    """Runs of each method."""
    runs: dict[str, list[Run]] = {}
    for each in outcomes:
        runs.setdefault(each.method, []).append(each.run)
    return runs


def calibrations(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], Calibration]:
    """By condition and method, over all assets; first over the paper's four conditions."""
    found: dict[tuple[str, str], Calibration] = {}
    conditions = sorted({each.run.condition for each in outcomes}, key=condition_order)
    for group in (OVERALL, *conditions):
        chosen = PAPER_CONDITIONS if group == OVERALL else (group,)
        for method, runs in by_method(outcomes).items():
            own = [run for run in runs if run.condition in chosen]
            if own:
                found[group, method] = calibration(own)
    return found
