"""Whether what a page prints is what came, in shape: keys and types, status, words; not numbers.

A printed object with the key "..." and a printed list with the element "..." are abridged. A null
on either side stands for a value that may be absent.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MORE = "..."
# What says which problem it is, is no example.
LITERAL = ("type", "title", "status")
# How many there are depends on how far the assembly is.
MAY_BE_EMPTY = ("finished_steps", "next_steps", "alternatives", "annotations", "misassemblies")
# Status codes are short; what is longer, or has a fraction, a sign or letters, is an example.
EXAMPLE = re.compile(r"(?<![\w.])(?=[\w.-]*\d)(?!\d{1,3}(?![\w.-]))[\w.-]+")


@dataclass(frozen=True)
class Example:
    """A block of commands and the answer that the page prints."""

    line: int
    code: str
    language: str
    answer: str

    def __str__(self) -> str:
        return f"line-{self.line}"


def examples(page: Path, language: str) -> list[Example]:
    """Blocks in this language, each with the block after it."""
    text = page.read_text(encoding="utf-8")
    pattern = rf"^```{language}\n(.*?)^```\n(?:\n```(json|text)\n(.*?)^```)?"
    return [
        Example(text[: it.start()].count("\n") + 1, it[1], it[2] or "", it[3] or "")
        for it in re.finditer(pattern, text, re.DOTALL | re.MULTILINE)
    ]


def differences(printed: Any, came: Any, where: str = "answer") -> Iterator[str]:
    """How the shape of a JSON value differs from what is printed."""
    if printed is None or came is None:
        return
    if isinstance(printed, dict) and isinstance(came, dict):
        missing = printed.keys() - came.keys() - {MORE}
        new = set() if MORE in printed else came.keys() - printed.keys()
        yield from (f"{where}.{key} did not come" for key in sorted(missing))
        yield from (f"{where}.{key} is not printed" for key in sorted(new))
        for key in printed.keys() & came.keys():
            if key in LITERAL and "detail" in printed and printed[key] != came[key]:
                yield f"{where}.{key} is {came[key]!r}, printed {printed[key]!r}"
            yield from differences(printed[key], came[key], f"{where}.{key}")
    elif isinstance(printed, list) and isinstance(came, list):
        shown = [each for each in printed if each != MORE]
        if shown and not came and where.rpartition(".")[2] not in MAY_BE_EMPTY:
            yield f"{where} is empty"
        if (
            printed
            and all(isinstance(each, float | int) for each in printed)
            and len(printed) != len(came)
        ):
            yield f"{where} has {len(came)} numbers, printed {len(printed)}"
        for place, each in enumerate(shown[: len(came)]):
            yield from differences(each, came[place], f"{where}[{place}]")
    elif kind(printed) != kind(came):
        yield f"{where} is {came!r}, printed {printed!r}"


def kind(value: Any) -> str:
    if isinstance(value, bool):
        return "bool"
    return "number" if isinstance(value, int | float) else type(value).__name__


def text_differences(printed: str, came: str) -> Iterator[str]:
    """Printed lines that did not come, in this order; a line "..." stands for any."""
    rest = iter(came.splitlines())
    for line in printed.splitlines():
        if line.strip() not in ("", MORE) and not any(is_like(line, it) for it in rest):
            yield f"{line!r} did not come"
            return


def is_like(printed: str, came: str) -> bool:
    """Whether two lines are the same but for examples of numbers and names."""
    if printed.startswith("data: {"):
        is_data = came.startswith("data: {")
        return is_data and not list(differences(json.loads(printed[6:]), json.loads(came[6:])))
    pieces = EXAMPLE.split(printed.rstrip())
    return re.fullmatch(r"[\w.+-]+".join(map(re.escape, pieces)), came.rstrip()) is not None
