"""Turns pydantic's complaints into one line for the person who wrote the file."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ValidationError


def describe(error: ValidationError, known_keys: Iterable[str]) -> tuple[str, str]:
    """The first problem of a validation, as (dotted key, what is wrong and what to do).

    Args:
        error: what pydantic raised.
        known_keys: keys that the file may hold, for a "did you mean" after a misspelt one.
    """
    problems = error.errors(include_url=False)
    # A misspelt key is also a missing one: the spelling is what helps.
    first = min(problems, key=lambda problem: problem["type"] != "extra_forbidden")
    key = dotted(first["loc"])
    problem = _sentence(first["type"], first["msg"], first.get("input"), first["loc"], known_keys)
    if len(problems) > 1:
        problem += f" (and {len(problems) - 1} more)"
    return key, problem


def dotted(location: Iterable[int | str]) -> str:
    """A key as it is written in the files' documentation: `state[1].link[0].parent`."""
    key = ""
    for item in location:
        if isinstance(item, int):
            key += f"[{item}]"
        else:
            key += f".{item}" if key else item
    return key


def field_keys(*models: Any) -> set[str]:
    """Every key that these pydantic models read, under the name it has in a file."""
    return {field.alias or name for model in models for name, field in model.model_fields.items()}


def _sentence(
    kind: str, message: str, value: object, location: tuple[int | str, ...], known: Iterable[str]
) -> str:
    if kind == "missing":
        return "is missing: add it"
    if kind == "extra_forbidden":
        name = str(location[-1])
        close = difflib.get_close_matches(name, sorted(known), n=1)
        hint = f"did you mean {close[0]!r}?" if close else "remove it, or check its spelling"
        return f"unknown key: {hint}"
    message = message.removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    if isinstance(value, Mapping | list | tuple) or value is None or kind == "value_error":
        return message
    return f"{message}, this is {value!r}"
