"""Precision and recall in cluttered images, as Markdown and for programs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from snapfit.tracking.benchmark.clutter import CRITERIA, LEAST_OVERLAP, NEAR_M, Tally
from snapfit.tracking.benchmark.provenance import Machine, command_line
from snapfit.tracking.benchmark.rightness import LEAST_SEEN, RIGHT_SHARE
from snapfit.tracking.benchmark.tables import number, plain_table

_ALL = "all assets"
_NAMES = ("box", "10 cm", "0.1 d")
_READING = f"""\
**recall**: of the parts of which at least {LEAST_SEEN:.0%} is seen, those that were found, %; \
**precision**: of all that was said, what is right, %. Each by three criteria: **box**, the right \
part in a box that overlaps the true one by {LEAST_OVERLAP:.0%} (intersection over union); \
**10 cm**, ADD(-S) under {100 * NEAR_M:.0f} cm; **0.1 d**, ADD(-S) under {RIGHT_SHARE:.0%} of the \
diameter. A part that is said twice is wrong once; one of which less is seen need not be said, and \
is right if it is. Parts of one mesh may stand for each other. **ms**: median of an image."""


def clutter_markdown(
    tallies: Sequence[Tally], commit: str, problems: Sequence[str] = (), note: str = ""
) -> str:
    """The whole report, of a commit's code.

    Args:
        tallies: by asset and method.
        commit: of the code.
        problems: why a method said nothing of an asset.
        note: which images these are.
    """
    machine = Machine.here()
    facts = [
        f"Command: `{command_line()}`",
        f"Commit: {commit} (+: with changes)",
        f"Machine: {machine.cpu}, {machine.n_cores} cores, {machine.system}",
        *([f"Images: {note}"] if note else []),
        *(f"Not run: {each}" for each in problems),
    ]
    titles = ["method", "asset", "images", "parts", "said"]
    titles += [f"{what} {each}" for what in ("recall", "precision") for each in _NAMES]
    cells = [_cells(each) for each in (*tallies, *sums(tallies))]
    table = plain_table([*titles, "ms"], cells, 2)
    lines = "\n".join(f"- {line}" for line in facts)
    return "\n\n".join(["# Detection in clutter", lines, _READING, table]) + "\n"


def clutter_json(tallies: Sequence[Tally], commit: str) -> dict[str, Any]:
    """For programs: figures by asset and method, and the counts of every part."""
    return {
        "command": command_line(),
        "commit": commit,
        "figures": [_record(each) for each in (*tallies, *sums(tallies))],
    }


def clutter_lines(tallies: Sequence[Tally]) -> Iterator[str]:
    """For the terminal: a line for each method and asset."""
    for each in (*tallies, *sums(tallies)):
        recall, precision = (
            ", ".join(number(100 * value(name), 1) for name in CRITERIA)
            for value in (each.recall, each.precision)
        )
        yield (
            f"{each.method}, {each.asset}: recall {recall} %, precision {precision} % "
            f"(box, 10 cm, 0.1 d) of {sum(each.parts.values())} parts in {each.images} images"
        )


def sums(tallies: Sequence[Tally]) -> list[Tally]:
    """Of several assets the sum by method; parts of different assets may have the same name."""
    found = []
    for method in dict.fromkeys(each.method for each in tallies):
        own = [each for each in tallies if each.method == method]
        if len(own) < 2:
            continue
        total = Tally(_ALL, method, sum(each.images for each in own))
        for each in own:
            for name in ("parts", "said", "found", "true"):
                counts: Counter[Any] = getattr(total, name)
                counts.update(getattr(each, name))
            total.times_ms += each.times_ms
        found.append(total)
    return found


def _cells(tally: Tally) -> list[str]:
    counts = tally.images, sum(tally.parts.values()), sum(tally.said.values())
    shares = [value(name) for value in (tally.recall, tally.precision) for name in CRITERIA]
    return [
        tally.method,
        tally.asset,
        *(str(count) for count in counts),
        *(number(100 * share, 1) for share in shares),
        number(float(np.median(tally.times_ms)), 0) if tally.times_ms else "-",
    ]


def _record(tally: Tally) -> dict[str, Any]:
    def percent(share: float) -> float | None:
        return None if math.isnan(share) else round(100 * share, 2)

    return {
        "asset": tally.asset,
        "method": tally.method,
        "images": tally.images,
        "recall_percent": {name: percent(tally.recall(name)) for name in CRITERIA},
        "precision_percent": {name: percent(tally.precision(name)) for name in CRITERIA},
        "parts": {
            part: {
                "wanted": tally.parts[part],
                "said": tally.said[part],
                "found": {name: tally.found[part, name] for name in CRITERIA},
                "true": {name: tally.true[part, name] for name in CRITERIA},
            }
            for part in sorted(tally.parts | tally.said)
        },
    }
