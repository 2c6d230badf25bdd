"""Figures of found mistakes, as Markdown and for programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from snapfit.models.workbench.mistake import MistakeKind
from snapfit.tracking.benchmark.mistakes import FOUND_FRAMES, Verdict, median_delay
from snapfit.tracking.benchmark.provenance import Machine, command_line
from snapfit.tracking.benchmark.tables import number, plain_table

_FIGURES = ("sequences", "found", "kind right", "delay", "false events", "state kept", "tracked")
_ALL = "all"
_READING = (
    f"Found: the right part reported within {FOUND_FRAMES} frames after it came to rest, in %. "
    "Kind right: also in what way it is wrong, in %. Delay: median frames until then, of the found "
    "ones. False events: reports of other parts, or of parts not at rest. State kept: no step was "
    "taken for done, in %. Tracked: the part's pose against its parent within 1 cm and 15 degrees, "
    "15 frames after it came to rest, in %: a part may be told to be wrong by a pose that is off."
)


def mistakes_markdown(verdicts: Sequence[Verdict], commit: str) -> str:
    """The whole report, of a commit's code."""
    machine = Machine.here()
    facts = (
        f"Command: `{command_line()}`",
        f"Commit: {commit} (+: with changes)",
        f"Machine: {machine.cpu}, {machine.n_cores} cores, {machine.system}",
    )
    blocks = [
        "# Mistakes",
        "\n".join(f"- {line}" for line in facts),
        _READING,
        _table("kind", verdicts, lambda each: each.mistake.kind, list(MistakeKind)),
        _table("asset", verdicts, lambda each: each.asset, []),
        "## Not found, another kind, or more than that",
        _failures(verdicts),
    ]
    return "\n\n".join(blocks) + "\n"


def mistakes_json(verdicts: Sequence[Verdict], commit: str) -> dict[str, Any]:
    """For programs: figures by method, kind and asset, and every sequence."""
    return {
        "command": command_line(),
        "commit": commit,
        "figures": [
            {"method": method, "group": group, "name": name, **_figures(own)}
            for group, key in (
                ("kind", lambda each: str(each.mistake.kind)),
                ("asset", lambda each: each.asset),
                (_ALL, lambda _: _ALL),
            )
            for method, name, own in _groups(verdicts, key, [])
        ],
        "sequences": [_record(each) for each in verdicts],
    }


def summary_line(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """For the terminal: a line for each method."""
    for method, _, own in _groups(verdicts, lambda _: _ALL, []):
        n_found, n_named = (
            sum(each.is_found for each in own),
            sum(each.is_named for each in own),
        )
        n_false = sum(len(each.false_events) for each in own)
        yield (
            f"{method}: {n_found} of {len(own)} found, {n_named} with the right kind, "
            f"{number(median_delay(own), 0)} frames after the rest; {n_false} false events"
        )


def _groups(
    verdicts: Sequence[Verdict], key: Callable[[Verdict], str], order: Sequence[str]
) -> Iterator[tuple[str, str, list[Verdict]]]:
    """(method, name, its verdicts), in an order or that of the names."""
    for method in dict.fromkeys(each.method for each in verdicts):
        names = list(order) or sorted({key(each) for each in verdicts})
        for name in names:
            own = [each for each in verdicts if each.method == method and key(each) == name]
            if own:
                yield method, name, own


def _table(
    title: str, verdicts: Sequence[Verdict], key: Callable[[Verdict], str], order: Sequence[str]
) -> str:
    rows = [*_groups(verdicts, key, order), *_groups(verdicts, lambda _: _ALL, [])]
    cells = []
    for method in dict.fromkeys(each.method for each in verdicts):
        for _, name, own in (row for row in rows if row[0] == method):
            figures = _figures(own)
            cells.append(
                [
                    method,
                    name.replace("_", " "),
                    str(figures["sequences"]),
                    number(figures["found_percent"], 1),
                    number(figures["kind_percent"], 1),
                    number(median_delay(own), 0),
                    str(figures["false_events"]),
                    number(figures["state_percent"], 1),
                    number(figures["tracked_percent"], 1),
                ]
            )
    return plain_table(["method", title, *_FIGURES], cells, 2)


def _figures(own: Sequence[Verdict]) -> dict[str, Any]:
    n = len(own)
    delay = median_delay(own)

    def percent(flags: Iterable[bool]) -> float:
        return round(100 * sum(flags) / n, 2)

    return {
        "sequences": n,
        "found_percent": percent(each.is_found for each in own),
        "kind_percent": percent(each.is_named for each in own),
        "delay_frames": None if delay != delay else delay,
        "false_events": sum(len(each.false_events) for each in own),
        "state_percent": percent(each.is_state_right for each in own),
        "tracked_percent": percent(each.is_pose_right for each in own),
    }


def _failures(verdicts: Sequence[Verdict]) -> str:
    cells = []
    for each in verdicts:
        if each.is_named and not each.false_events and each.is_state_right:
            continue
        mistake = each.mistake
        off = "lost" if each.off_mm is None else f"{each.off_mm:.1f} mm {each.off_deg:.1f} deg"
        cells.append(
            [
                each.method,
                f"{each.asset} {each.sequence}",
                f"{mistake.part}: {mistake.kind.replace('_', ' ')}",
                "-" if each.delay_frames is None else str(each.delay_frames),
                each.reported_kind.replace("_", " ") or "-",
                ", ".join(each.false_events) or "-",
                "kept" if each.is_state_right else each.last_state,
                off,
            ]
        )
    titles = [
        "method",
        "sequence",
        "mistake",
        "delay",
        "reported",
        "false events",
        "state",
        "pose off by",
    ]
    return plain_table(titles, cells, 8) if cells else "Nothing."


def _record(verdict: Verdict) -> dict[str, Any]:
    fields = {name: value for name, value in vars(verdict).items() if name != "mistake"}
    judged = {"is_found": verdict.is_found, "is_named": verdict.is_named}
    return fields | judged | {"mistake": verdict.mistake.model_dump(mode="json")}
