"""docker/compose.yaml as Compose reads it: anchors merged, variables filled in."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
DOCKER = ROOT / "docker"
COMPOSE = DOCKER / "compose.yaml"
OVERRIDES = sorted(DOCKER.glob("compose.*.yaml"))
_VARIABLE = re.compile(r"\$\{(\w+)(?::([-?])([^}]*))?\}")


def dotenv() -> dict[str, str]:
    """The variables of docker/.env."""
    lines = (DOCKER / ".env").read_text("utf-8").splitlines()
    return dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))


def variables(path: Path = COMPOSE) -> dict[str, str]:
    """The variables that a file asks for, each with its default."""
    found: dict[str, str] = {}
    for name, _, default in _VARIABLE.findall(path.read_text("utf-8")):
        assert found.setdefault(name, default) == default, f"{name} has two defaults"
    return found


def load(path: Path = COMPOSE) -> dict[str, Any]:
    """The file, with its variables' defaults."""
    text = _VARIABLE.sub(lambda it: it[3], path.read_text("utf-8"))
    document: dict[str, Any] = yaml.safe_load(text)
    return document


def services(profile: str | None = None) -> dict[str, dict[str, Any]]:
    """The services, or those of a profile."""
    every: dict[str, dict[str, Any]] = load()["services"]
    return {
        name: service
        for name, service in every.items()
        if profile is None or profile in service["profiles"]
    }


def volumes(service: dict[str, Any]) -> dict[str, tuple[str, bool]]:
    """What is mounted, by the place in the container: the source, and whether it can be written."""
    found = {}
    for mount in service.get("volumes", []):
        source, place, *how = mount.split(":")
        found[place] = (source, how != ["ro"])
    return found


def tool(*names: str) -> str:
    """The first program of these that is there; skips the test where none is."""
    for name in names:
        if path := shutil.which(name):
            return path
    pytest.skip(f"there is no {' or '.join(names)}: .ci/run installs it")


def run(*command: str | Path, limit_s: float = 400) -> str:
    """What a program prints, which has to succeed."""
    done = subprocess.run(
        [str(word) for word in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=limit_s,
        check=False,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout
