"""docs/python-client.md: its examples run, and print what the page says, but for numbers."""

from __future__ import annotations

import contextlib
import io
import re
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from harness import Server, wait_for
from page_shape import Example, examples, text_differences

from snapfit.clients import python as package
from snapfit.clients.python import Client

PAGE = Path(__file__).parents[2] / "docs" / "python-client.md"


def test_the_examples_print_what_the_page_says(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"http://127.0.0.1:{server.port}"
    monkeypatch.chdir(tmp_path)
    events = Client.events
    monkeypatch.setattr(
        Client,
        "events",
        lambda self: events(self, on_open=lambda: operator.set_state("jaw-mounted")),
    )
    names: dict[str, Any] = {}
    with Client(url) as operator:
        operator.set_state("free")
        for example in examples(PAGE, "python"):
            wait_for(lambda: operator.pose("jaw").pose.position)
            assert example.answer, f"line {example.line} prints nothing"
            said = partial(differences, example, url, names)
            if "at_us=" in example.code:  # too far ahead of what a held up server has
                wait_for(lambda said=said: not said())
            else:
                assert said() == []
        names["client"].close()
        names["error"] = None


def differences(example: Example, url: str, names: dict[str, Any]) -> list[str]:
    """In what an example prints something else than the page says."""
    printed = io.StringIO()
    code = example.code.replace("http://127.0.0.1:8000", url)
    with contextlib.redirect_stdout(printed):
        exec(compile(code, f"{PAGE.name}:{example.line}", "exec"), names)
    return list(text_differences(example.answer, printed.getvalue()))


def test_every_error_is_told() -> None:
    told = set(re.findall(r"`(\w+Error)`", PAGE.read_text(encoding="utf-8")))
    classes = {name for name in package.__all__ if name.endswith("Error")}
    assert told == classes - {"ProblemError"}
