"""Figures of cold starts and of covered cameras, as Markdown and for programs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from snapfit.tracking.benchmark.provenance import Machine, command_line
from snapfit.tracking.benchmark.recovery import (
    COVERED_S,
    EVERY_FRAMES,
    LEAD_S,
    LIMIT_S,
    Recovered,
    TrialKind,
)
from snapfit.tracking.benchmark.rightness import LEAST_SEEN, RIGHT_SHARE
from snapfit.tracking.benchmark.sequences import condition_order
from snapfit.tracking.benchmark.tables import number, plain_table

TARGET_S = {TrialKind.COLD: 1.0, TrialKind.COVERED: 0.5}
"""The median is to be no longer."""

_ALL = "all assets"
_TITLES = ("trials", "median", "p90", "in time", "never", "last to be right")
_READING = f"""\
Frames from the first one that shows a part to the first one in which all parts are right at \
once: ADD(-S) under {RIGHT_SHARE:.0%} of the diameter, of every part of which at least \
{LEAST_SEEN:.0%} is seen. **median**, **p90**: of all trials, those without end being longer than \
any; **in time**: trials within the target, %; **never**: trials in which it had not come after \
{LIMIT_S:.0f} s, %; **last to be right**: the part that was wrong most often when a trial was \
given up. Trials begin at every {EVERY_FRAMES}th frame of a sequence, also in the midst of the \
assembly. What a detector finds comes as many frames later as its declared latency lasts.

- **Cold start.** No pose and no state is told. Parts of one mesh may stand for each other: \
nobody can see which is which.
- **Covered camera.** Poses and state of the trial's first frame are told; {LEAD_S:.0f} s later \
the camera is covered for {COVERED_S:.0f} s, by a hand on its lens (black, no depth) or by one \
20 cm before it, in turns, while the assembly goes on."""

_Key = Callable[[Recovered], str]


def recovery_markdown(results: Sequence[Recovered], commit: str, problems: Sequence[str]) -> str:
    """The whole report, of a commit's code.

    Args:
        results: of all trials.
        commit: of the code.
        problems: why methods could not be tried.
    """
    machine = Machine.here()
    facts = [
        f"Command: `{command_line()}`",
        f"Commit: {commit} (+: with changes)",
        f"Machine: {machine.cpu}, {machine.n_cores} cores, {machine.system}",
        *(f"Not run: {each}" for each in problems),
    ]
    blocks = ["# Recovery", "\n".join(f"- {line}" for line in facts), _READING]
    for kind in TrialKind:
        own = [each for each in results if each.kind is kind]
        if not own:
            continue
        frames = TARGET_S[kind] * own[0].rate_hz
        target = f"Target: a median of at most {frames:.0f} frames ({TARGET_S[kind]:g} s)."
        blocks += [f"## {kind.value.capitalize()}", target]
        blocks.append(_table("asset", own, lambda each: each.asset))
        if len({each.condition for each in own}) > 1:
            blocks.append(_table("condition", own, lambda each: each.condition))
    return "\n\n".join(blocks) + "\n"


def recovery_json(results: Sequence[Recovered], commit: str) -> dict[str, Any]:
    """For programs: figures by method, kind, asset and condition, and every trial."""
    return {
        "command": command_line(),
        "commit": commit,
        "figures": [
            {"kind": kind.value, "method": method, key: name, **_figures(own)}
            for kind in TrialKind
            for key, of in (("asset", lambda each: each.asset), ("condition", _condition))
            for method, name, own in _groups([r for r in results if r.kind is kind], of)
        ],
        "trials": [asdict(each) for each in results],
    }


def recovery_lines(results: Sequence[Recovered]) -> Iterator[str]:
    """For the terminal: a line for each kind and method."""
    for kind in TrialKind:
        for method in dict.fromkeys(each.method for each in results if each.kind is kind):
            own = [each for each in results if each.kind is kind and each.method == method]
            figures = _figures(own)
            yield (
                f"{kind.value}, {method}: {number(figures['median'], 0)} frames (median), "
                f"{number(figures['p90'], 0)} (p90), {number(figures['never_percent'], 1)} % never "
                f"of {len(own)} trials"
            )


def _condition(each: Recovered) -> str:
    return each.condition


def _table(title: str, results: Sequence[Recovered], key: _Key) -> str:
    cells = []
    for method in dict.fromkeys(each.method for each in results):
        own = [each for each in results if each.method == method]
        for _, name, group in (*_groups(own, key), *(((method, _ALL, own),))):
            figures = _figures(group)
            cells.append(
                [
                    method,
                    name if title == "asset" or name != _ALL else "all conditions",
                    str(figures["trials"]),
                    number(figures["median"], 0),
                    number(figures["p90"], 0),
                    number(figures["in_time_percent"], 1),
                    number(figures["never_percent"], 1),
                    figures["last_part"] or "-",
                ]
            )
    return plain_table(["method", title, *_TITLES], cells, 2)


def _groups(results: Sequence[Recovered], key: _Key) -> Iterator[tuple[str, str, list[Recovered]]]:
    """(method, name, its trials); conditions in the order of the other tables."""
    for method in dict.fromkeys(each.method for each in results):
        own = [each for each in results if each.method == method]
        for name in sorted({key(each) for each in own}, key=condition_order):
            yield method, name, [each for each in own if key(each) == name]


def _figures(own: Sequence[Recovered]) -> dict[str, Any]:
    frames = np.array([np.inf if each.frames is None else each.frames for each in own])
    target = TARGET_S[own[0].kind] * own[0].rate_hz
    last = [name for each in own if each.frames is None for name in each.wrong]
    return {
        "trials": len(own),
        # Of frames that were taken, never of a mean: between a number and never there is none.
        "median": float(np.quantile(frames, 0.5, method="inverted_cdf")),
        "p90": float(np.quantile(frames, 0.9, method="inverted_cdf")),
        "in_time_percent": 100 * float(np.mean(frames <= target)),
        "never_percent": 100 * float(np.mean(np.isinf(frames))),
        "last_part": max(sorted(set(last)), key=last.count) if last else None,
    }
