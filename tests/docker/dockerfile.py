"""docker/Dockerfile as a list of instructions, stage by stage."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
DOCKERFILE = ROOT / "docker" / "Dockerfile"


class Instruction(NamedTuple):
    """One instruction."""

    name: str
    rest: str


class Stage(NamedTuple):
    """From one FROM to the next; `name` is "" for what stands before the first."""

    name: str
    parent: str
    instructions: list[Instruction]

    def all(self, name: str) -> list[str]:
        return [each.rest for each in self.instructions if each.name == name]


def read_dockerfile() -> dict[str, Stage]:
    """The stages by name, in their order."""
    lines = DOCKERFILE.read_text(encoding="utf-8").splitlines()
    text = "\n".join(line for line in lines if not line.lstrip().startswith("#"))
    stages = {"": Stage("", "", [])}
    stage = stages[""]
    for line in text.replace("\\\n", " ").splitlines():
        name, _, rest = line.strip().partition(" ")
        if name == "FROM":
            parent, _, own = rest.partition(" AS ")
            stage = stages[own] = Stage(own, parent, [])
        elif name:
            stage.instructions.append(Instruction(name, " ".join(rest.split())))
    return stages


def ancestry(name: str) -> list[Stage]:
    """A stage and those that it stands on, the first one first."""
    stages = read_dockerfile()
    found: list[Stage] = []
    while name in stages and name:
        found.insert(0, stages[name])
        name = stages[name].parent
    return found


def instructions(target: str, name: str) -> list[str]:
    """What an image has of an instruction, its ancestors' first."""
    return [rest for stage in ancestry(target) for rest in stage.all(name)]


def environment(target: str) -> dict[str, str]:
    """The ENV of an image."""
    pairs = [pair for rest in instructions(target, "ENV") for pair in shlex.split(rest)]
    return dict(pair.split("=", 1) for pair in pairs)
