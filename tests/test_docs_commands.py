"""Every command on our pages exists: make targets, sub-commands and their options, API paths."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import typer

from snapfit.server.cli.main import app

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "docker" / "README.md"]
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
OPENAPI = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
OUTSIDE_OPENAPI = {"/", "/docs", "/openapi.json"}
TOOLS = {"pytest", "ruff", "mypy", "lint-imports", "pip", "python", "npm", "sleep", "wait"}
METHODS = "GET|POST|PUT|DELETE"


def shell_commands(page: str) -> list[str]:
    """Lines of ```sh blocks, and inline code that begins with one of our commands."""
    blocks = re.findall(r"^```(?:sh|bash|console)\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    prose = re.sub(r"^```.*?^```", "", page, flags=re.DOTALL | re.MULTILINE)
    inline = re.findall(r"`((?:make|snapfit|\.venv/bin/\w+) [^`\n]+)`", prose)
    return [line.strip() for line in (*lines, *inline) if line.strip()]


def api_paths(page: str) -> list[str]:
    """Paths that the page tells with their method."""
    return re.findall(rf"`(?:{METHODS}) (/[^\s`]*)`", page)


def problem_of(command: str) -> str | None:
    """Why a command cannot be run; None if it can."""
    words = shlex.split(command, comments=True)
    program = words[0].removeprefix(".venv/bin/")
    if program == "make":
        targets = [word for word in words[1:] if "=" not in word]
        missing = [target for target in targets if target not in TARGETS]
        return f"no make target {missing}" if missing else None
    if program == "snapfit":
        return problem_of_snapfit(words[1:])
    if program == "curl":
        urls = [word for word in words if word.startswith("http")]
        return problem_of_path(urlsplit(urls[0]).path) if urls else "curl without an address"
    if program == "docker":
        return None if words[1] in {"build", "run"} else f"docker {words[1]} is not known here"
    return None if program in TOOLS else f"{program} is not known here"


def problem_of_snapfit(words: list[str]) -> str | None:
    command: Any = typer.main.get_command(app)
    while words and hasattr(command, "commands"):
        if words[0] in {"--help", "--version"}:
            return None
        if words[0] not in command.commands:
            return f"no command {words[0]!r}"
        command = command.commands[words.pop(0)]
    options = {"--help"}
    for parameter in command.params:
        options |= {*parameter.opts, *parameter.secondary_opts}
    unknown = [word for word in words if word.startswith("-") and word not in options]
    return f"{command.name} has no option {unknown}" if unknown else None


def problem_of_path(path: str) -> str | None:
    for known in {*OPENAPI["paths"], *OUTSIDE_OPENAPI}:
        if path == known or re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", known), path):
            return None
    return f"no path {path} in openapi.json"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_tells_to_run_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    commands = {command: problem_of(command) for command in shell_commands(text)}
    paths = {path: problem_of_path(path) for path in api_paths(text)}
    problems = {told: problem for told, problem in {**commands, **paths}.items() if problem}
    assert problems == {}


def test_the_readme_tells_the_two_commands_and_every_endpoint() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert {"make demo", "make test"} <= set(shell_commands(text))
    told = set(api_paths(text))
    assert (
        set(OPENAPI["paths"]) - told - {f"/v1/stations/{{station}}{it[3:]}" for it in told} == set()
    )


def test_the_readme_tells_every_command() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    command: Any = typer.main.get_command(app)
    told = set(re.findall(r"snapfit ([a-z]+)", " ".join(shell_commands(text))))
    assert set(command.commands) - {"openapi"} <= told


def test_the_development_page_tells_every_make_target() -> None:
    text = (ROOT / "docs" / "development.md").read_text(encoding="utf-8")
    told = {command.split()[1] for command in shell_commands(text) if command.startswith("make ")}
    assert told == TARGETS


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("make coffee", "no make target"),
        ("snapfit find", "no command"),
        (".venv/bin/snapfit asset buy x", "no command"),
        ("snapfit track x --fast", "has no option"),
        ("curl http://127.0.0.1:8000/v2/poses", "no path"),
        ("rm -rf .", "is not known here"),
    ],
)
def test_a_command_that_does_not_exist_is_noticed(command: str, problem: str) -> None:
    assert problem in (problem_of(command) or "")
