"""docker/Dockerfile read, not built: what it copies, runs and promises exists."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

import typer

from snapfit.models.cache import CACHE_VARIABLE
from snapfit.server.cli.main import app
from snapfit.server.security.settings import SecuritySettings
from snapfit.server.settings import Settings

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
KEYS_FILE = "SNAPFIT_SECURITY__KEYS_FILE"
OPENAPI = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))


class Instruction(NamedTuple):
    """One instruction and the number of the stage that it stands in, from 0; -1 before."""

    stage: int
    name: str
    rest: str


def read_dockerfile() -> list[Instruction]:
    text = (ROOT / "docker" / "Dockerfile").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    found, stage = [], -1
    for line in "\n".join(lines).replace("\\\n", " ").splitlines():
        name, _, rest = line.strip().partition(" ")
        if not name:
            continue
        stage += name == "FROM"
        found.append(Instruction(stage, name, " ".join(rest.split())))
    return found


INSTRUCTIONS = read_dockerfile()
LAST = max(instruction.stage for instruction in INSTRUCTIONS)


def last_stage(name: str) -> list[str]:
    return [each.rest for each in INSTRUCTIONS if each.stage == LAST and each.name == name]


def copied_sources() -> list[str]:
    """What is copied from the repository, not from another stage."""
    copies = [each.rest for each in INSTRUCTIONS if each.name == "COPY"]
    return [source for rest in copies if "--from=" not in rest for source in shlex.split(rest)[:-1]]


def environment() -> dict[str, str]:
    pairs = [shlex.split(rest) for rest in last_stage("ENV")]
    return dict(pair.split("=", 1) for each in pairs for pair in each)


def test_every_instruction_is_one_that_docker_knows() -> None:
    known = "ARG FROM ENV RUN WORKDIR COPY LABEL USER VOLUME EXPOSE STOPSIGNAL HEALTHCHECK"
    assert {each.name for each in INSTRUCTIONS} <= {*known.split(), "ENTRYPOINT", "CMD"}


def test_what_is_copied_exists_and_is_all_that_is_installed() -> None:
    sources = copied_sources()
    assert [source for source in sources if not (ROOT / source).exists()] == []
    rooms = set(PROJECT["tool"]["setuptools"]["package-dir"].values())
    named = {PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]}
    assert set(sources) == {"pyproject.toml", *named, *rooms}


def test_what_is_copied_is_not_ignored() -> None:
    lines = (ROOT / "docker" / "Dockerfile.dockerignore").read_text("utf-8").splitlines()
    patterns = [line for line in lines if line and not line.startswith("#")]
    for source in copied_sources():
        ignored = False
        for pattern in patterns:
            if fnmatch(source, pattern.removeprefix("!")):
                ignored = not pattern.startswith("!")
        assert not ignored, source


def test_stages_that_are_copied_from_exist() -> None:
    froms = [each.rest for each in INSTRUCTIONS if each.name == "FROM"]
    names = [rest.split(" AS ")[1] for rest in froms if " AS " in rest]
    wanted = re.findall(r"--from=(\S+)", " ".join(each.rest for each in INSTRUCTIONS))
    assert LAST >= 1
    assert wanted
    assert set(wanted) <= set(names)


def test_the_python_is_one_that_is_promised() -> None:
    (version,) = [each.rest for each in INSTRUCTIONS if each.name == "ARG"]
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert f'"{version.removeprefix("PYTHON=")}"' in workflow


def test_the_command_exists() -> None:
    (entrypoint,), (command,) = last_stage("ENTRYPOINT"), last_stage("CMD")
    assert json.loads(entrypoint)[0] in PROJECT["project"]["scripts"]
    cli = typer.main.get_command(app)
    commands = getattr(cli, "commands", {})
    assert {json.loads(command)[0], "serve"} <= set(commands)


def test_the_user_is_not_root_and_may_write_the_cache() -> None:
    (user,) = last_stage("USER")
    assert user.partition(":")[0] not in {"root", "0", ""}
    instructions = [each for each in INSTRUCTIONS if each.stage == LAST]
    (made,) = [each.rest for each in instructions if each.name == "RUN"]
    assert f"--owner={user}" in made
    assert environment()[CACHE_VARIABLE] in last_stage("VOLUME")
    assert f" {environment()[CACHE_VARIABLE]} " in f"{made} "
    names = [each.name for each in instructions]
    assert names.index("USER") > names.index("RUN")
    assert names.index("USER") < names.index("ENTRYPOINT")


def test_the_settings_of_the_image_are_settings() -> None:
    variables = {f"SNAPFIT_{name.upper()}" for name in Settings.model_fields}
    variables |= {f"SNAPFIT_SECURITY__{name.upper()}" for name in SecuritySettings.model_fields}
    own = {name for name in environment() if name.startswith("SNAPFIT_")}
    assert own - {CACHE_VARIABLE} == {"SNAPFIT_HOST", "SNAPFIT_PORT", KEYS_FILE} <= variables
    assert Path(environment()[KEYS_FILE]).parent == Path(environment()[CACHE_VARIABLE])
    assert last_stage("EXPOSE") == [environment()["SNAPFIT_PORT"]]


def test_the_health_check_is_python_and_asks_an_endpoint() -> None:
    (check,) = last_stage("HEALTHCHECK")
    command = json.loads(check.partition("CMD ")[2])
    assert command[:2] == ["python", "-c"]
    compile(command[2], "HEALTHCHECK", "exec")
    paths = re.findall(r"'(/[^']*)'", command[2])
    assert paths
    assert set(paths) <= set(OPENAPI["paths"])
