"""The benchmark's figures for programs: what becomes `benchmark.json`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from snapfit.tracking.benchmark.benchmark import Failure, Outcome
from snapfit.tracking.benchmark.groups import calibrations, methods_of
from snapfit.tracking.benchmark.losses import losses
from snapfit.tracking.benchmark.report import Provenance
from snapfit.tracking.benchmark.roster import ablations
from snapfit.tracking.benchmark.scores import part_scores
from snapfit.tracking.benchmark.tables import Row, by_condition, overall, rows_of


def as_json(
    outcomes: Sequence[Outcome], provenance: Provenance, failures: Sequence[Failure] = ()
) -> dict[str, Any]:
    """All figures; None where there is no answer or it is infinite."""
    rows = rows_of(outcomes)
    record = {
        "provenance": asdict(provenance),
        "rows": [_sequence_record(each, row) for row, each in zip(rows, outcomes, strict=True)],
        "means": [_row_record(row) for row in overall(rows)],
        "by_condition": [_row_record(row) for row in by_condition(rows)],
        "calibration": [
            {"condition": condition, "method": method, **asdict(each)}
            for (condition, method), each in calibrations(outcomes).items()
        ],
        "ablations": ablations(methods_of(outcomes)),
        "failures": [
            {"sequence": each.folder.name, "method": each.method, "problem": each.problem}
            for each in failures
        ],
    }
    finite: dict[str, Any] = _finite(record)
    return finite


def _sequence_record(outcome: Outcome, row: Row) -> dict[str, Any]:
    return {
        **_row_record(row),
        "method": outcome.method,
        "is_told_state": outcome.run.is_told_state,
        "n_frames": len(outcome.run.frames),
        "parts": {name: asdict(score) for name, score in part_scores(outcome.run).items()},
        "losses": [asdict(loss) for loss in losses(outcome.run)],
        "circumstances": asdict(outcome.circumstances),
        "run": outcome.path.name,
    }


def _row_record(row: Row) -> dict[str, Any]:
    names = {"asset": row.asset, "condition": row.condition, "method": row.method}
    return names | {"score": asdict(row.score)}


def _finite(value: Any) -> Any:
    """The value with None for every number that JSON does not know."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value
