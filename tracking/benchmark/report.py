"""The benchmark's figures as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from snapfit.tracking.benchmark.benchmark import Failure, Outcome
from snapfit.tracking.benchmark.calibration import Calibration
from snapfit.tracking.benchmark.groups import by_method, calibrations, methods_of
from snapfit.tracking.benchmark.losses import losses
from snapfit.tracking.benchmark.reading import READING
from snapfit.tracking.benchmark.roster import ablations, summary
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.scores import part_scores
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.benchmark.states import changes
from snapfit.tracking.benchmark.tables import (
    ABLATION_COLUMNS,
    OVERALL,
    PAPER_COLUMNS,
    STATE_COLUMNS,
    STRICT_COLUMNS,
    TOLD,
    Column,
    Row,
    by_condition,
    method_title,
    number,
    overall,
    plain_table,
    rows_of,
    table,
)

_BUSY = 0.5
"""Load beyond the number of cores from which on times are marked."""

_ABLATION_CONDITIONS = (OVERALL, "hand", "all")


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


def markdown(
    outcomes: Sequence[Outcome], provenance: Provenance, failures: Sequence[Failure] = ()
) -> str:
    """The whole report, with a heading of the second level for each section."""
    rows = rows_of(outcomes)
    blocks = [
        "# Benchmark",
        "\n".join(f"- {line}" for line in _facts(outcomes, provenance)),
        *_failures(failures),
        *_methods(outcomes),
        "## Data",
        _data_table(outcomes),
        "## Overall",
        *_score_tables(overall(rows)),
        "## By condition",
        *_score_tables(by_condition(rows)),
    ]
    for asset in dict.fromkeys(row.asset for row in rows):
        own = [row for row in rows if row.asset == asset]
        blocks += [f"## {asset}", *_score_tables(own)]
    blocks += [
        *_ablations(outcomes, rows),
        "## Lost parts",
        _loss_table(outcomes),
        "## Confidence and covariance",
        _calibration_table(outcomes),
        "## How to read it",
        READING,
    ]
    return "\n\n".join(blocks) + "\n"


def parts_markdown(outcomes: Sequence[Outcome]) -> str:
    """The scores of every part, asset, condition and method in one long table."""
    columns = [*PAPER_COLUMNS[:-1], *STRICT_COLUMNS[:-1]]
    cells = []
    for each in outcomes:
        run = each.run
        for name, score in part_scores(run).items():
            title = _part_title(run, name)
            figures = [show(score) for _, show in columns]
            cells.append([run.asset, run.condition, method_title(run), title, *figures])
    titles = ["asset", "condition", "method", "part", *(title for title, _ in columns)]
    return f"# Benchmark by part\n\n{plain_table(titles, cells, 4)}\n"


def _facts(outcomes: Sequence[Outcome], provenance: Provenance) -> Iterator[str]:
    yield f"Command: `{provenance.command}`"
    commits: dict[str, dict[str, None]] = {}
    for each in outcomes:
        commits.setdefault(each.circumstances.commit, {})[each.method] = None
    by = "; ".join(f"{commit} ({', '.join(methods)})" for commit, methods in commits.items())
    yield f"Commit: {by} (+: with changes)"
    for machine in dict.fromkeys(each.circumstances.machine for each in outcomes):
        yield f"Machine: {machine.cpu}, {machine.n_cores} cores; {machine.system}"
    yield f"Data: {provenance.note or 'says nothing of its seed'}"
    sequences = _longest(outcomes)
    n_frames, n_sequences = sum(len(run.frames) for run in sequences.values()), len(sequences)
    limit = provenance.most_frames
    some = f", the first {limit} of each: a quick look, no result" if limit else ""
    yield f"Frames: {n_frames} in {n_sequences} sequences{some}"
    yield from _time_facts(outcomes)


def _time_facts(outcomes: Sequence[Outcome]) -> Iterator[str]:
    circumstances = [each.circumstances for each in outcomes]
    n_jobs = max(each.n_jobs for each in circumstances)
    n_threads = max(each.n_threads for each in circumstances)
    threads = f"{n_threads} {'thread' if n_threads == 1 else 'threads'}"
    if n_jobs > 1:
        beside = f"{n_jobs} sequences ran side by side, on {threads} each"
        yield f"**Times are not to be trusted: {beside}**; `make bench` measures speed"
    else:
        yield f"Times: one sequence at a time, on {threads}"
    busy = max((each.load or 0.0) - each.machine.n_cores for each in circumstances)
    if busy > _BUSY:
        yield f"**Times are too long: {busy:.1f} more processes than cores wanted to run**"


def _methods(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """What the methods are, where the table of methods says it."""
    summaries = {title: summary(each.method) for title, each in _titles(outcomes).items()}
    lines = [f"- `{title}`: {text}" for title, text in summaries.items() if text]
    if lines:
        yield "## Methods"
        yield "\n".join(lines)


def _titles(outcomes: Sequence[Outcome]) -> dict[str, Outcome]:
    """An outcome of each method, by the method's title."""
    return {method_title(each.run): each for each in outcomes}


def _failures(failures: Sequence[Failure]) -> Iterator[str]:
    """What is missing, and hence missing in all means."""
    if failures:
        yield f"**{len(failures)} runs are missing here, and in the means:**"
        # A sequence that nobody could run is told once.
        problems: dict[tuple[str, str], list[str]] = {}
        for each in failures:
            problems.setdefault((each.folder.name, each.problem), []).append(each.method)
        yield "\n".join(
            f"- {name}, {', '.join(methods)}: {problem}"
            for (name, problem), methods in problems.items()
        )


def _data_table(outcomes: Sequence[Outcome]) -> str:
    cells = []
    sequences = _longest(outcomes)
    for asset in dict.fromkeys(folder.asset for folder in sequences):
        runs = [run for folder, run in sequences.items() if folder.asset == asset]
        run = runs[0]
        names = ", ".join(_part_title(run, name) for name in run.parts)
        conditions = ", ".join(each.condition for each in runs)
        lengths = dict.fromkeys(str(len(each.frames)) for each in runs)
        n_switches = len(changes(run.true_states.tolist()))
        cells.append([asset, names, conditions, " or ".join(lengths), str(n_switches)])
    return plain_table(["asset", "parts", "conditions", "frames each", "switches"], cells, 3)


def _longest(outcomes: Sequence[Outcome]) -> dict[SequenceFolder, Run]:
    """By sequence a run of one of the methods that were shown the most frames of it."""
    runs: dict[SequenceFolder, Run] = {}
    for each in outcomes:
        known = runs.get(each.folder)
        if known is None or len(each.run.frames) > len(known.frames):
            runs[each.folder] = each.run
    return runs


def _part_title(run: Run, name: str) -> str:
    return f"{name} (s)" if run.symmetric[run.parts.index(name)] else name


def _score_tables(rows: Sequence[Row]) -> Iterator[str]:
    """The paper's figures and the strict ones, and states where somebody reports some."""
    groups: list[tuple[str, Sequence[Column]]] = [
        ("As in the paper", PAPER_COLUMNS),
        ("Strict", STRICT_COLUMNS),
    ]
    for title, columns in groups:
        yield f"{title}:"
        yield table(rows, columns)
    dashes = {"-"}
    judged = [row for row in rows if {show(row.score) for _, show in STATE_COLUMNS} != dashes]
    if judged:
        yield "Assembly state:"
        yield table(judged, STATE_COLUMNS)


def _ablations(outcomes: Sequence[Outcome], rows: Sequence[Row]) -> Iterator[str]:
    means = [*overall(rows), *by_condition(rows)]
    for whole, methods in ablations(methods_of(outcomes)).items():
        yield f"## What is left out of {whole}"
        chosen: dict[tuple[str, str], Row] = {}
        for condition in _ABLATION_CONDITIONS:
            for method in methods:
                for row in means:
                    if (row.condition, row.method.removesuffix(TOLD)) == (condition, method):
                        chosen.setdefault((condition, method), row)
        yield table(list(chosen.values()), ABLATION_COLUMNS)


def _loss_table(outcomes: Sequence[Outcome]) -> str:
    cells = []
    for each in outcomes:
        found = losses(each.run)
        if found:
            run, n = each.run, len({loss.part for loss in found})
            texts = ", ".join(loss.text for loss in found)
            cells.append([run.asset, run.condition, method_title(run), texts, str(n)])
    if not cells:
        return "No method lost a part."
    return plain_table(
        ["asset", "condition", "method", "lost from frame to frame", "parts"], cells, 4
    )


def _calibration_table(outcomes: Sequence[Outcome]) -> str:
    names = ["condition", "method", "ECE", "NEES", "rotation", "translation", "right", "median"]
    cells = []
    statuses: list[str] = []
    for (condition, method), each in calibrations(outcomes).items():
        statuses = list(each.statuses)
        title = method_title(by_method(outcomes)[method][0])
        cells.append([condition, title, *_calibration_cells(each)])
    return plain_table([*names, "95 %", *statuses], cells, 2)


def _calibration_cells(each: Calibration) -> list[str]:
    nees = each.consistency
    means = (nees.mean, nees.rotation, nees.translation, nees.mean_of_right, nees.median)
    return [
        number(100 * each.reliability.calibration_error, 1),
        *(number(mean, 2) for mean in means),
        number(100 * nees.covered, 1),
        *(number(100 * share, 1) for share in each.statuses.values()),
    ]
