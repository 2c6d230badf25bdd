"""docker/Dockerfile read, not built: what it copies, installs, runs and promises exists."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest
import typer
from compose_file import run, tool
from dockerfile import DOCKERFILE, ROOT, ancestry, environment, instructions, read_dockerfile

from snapfit.models.cache import CACHE_VARIABLE
from snapfit.server.cli.main import app
from snapfit.server.security.settings import SecuritySettings
from snapfit.server.settings import Settings

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
KEYS_FILE = "SNAPFIT_SECURITY__KEYS_FILE"
TARGETS = ("api", "worker")
# What the API process never imports, and what comes with it.
TRACKING_STACK = ("numba", "open3d", "onnxruntime", "opencv", "scipy", "trimesh", "manifold3d")


def copied_sources() -> list[str]:
    """What is copied from the repository, not from another stage."""
    copies = [rest for stage in read_dockerfile().values() for rest in stage.all("COPY")]
    return [source for rest in copies if "--from=" not in rest for source in shlex.split(rest)[:-1]]


def requirements(*arguments: str) -> list[str]:
    script = str(ROOT / "docker" / "requirements.py")
    return run(sys.executable, script, *arguments).splitlines()


def test_every_instruction_is_one_that_docker_knows() -> None:
    known = "ARG ENV RUN WORKDIR COPY LABEL USER VOLUME EXPOSE STOPSIGNAL HEALTHCHECK"
    found = {each.name for stage in read_dockerfile().values() for each in stage.instructions}
    assert found <= {*known.split(), "ENTRYPOINT", "CMD"}


def test_the_linter_has_nothing_to_say() -> None:
    assert run(tool("hadolint"), "--failure-threshold", "style", DOCKERFILE) == ""


def test_what_is_copied_exists_and_is_all_that_is_installed() -> None:
    sources = copied_sources()
    assert [source for source in sources if not (ROOT / source).exists()] == []
    rooms = set(PROJECT["tool"]["setuptools"]["package-dir"].values())
    named = {PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]}
    assert set(sources) == {"pyproject.toml", "docker/requirements.py", *named, *rooms}


def test_what_is_copied_is_not_ignored() -> None:
    lines = (ROOT / "docker" / "Dockerfile.dockerignore").read_text("utf-8").splitlines()
    patterns = [line for line in lines if line and not line.startswith("#")]
    for source in copied_sources():
        ignored = False
        for pattern in patterns:
            if fnmatch(source, pattern.removeprefix("!")):
                ignored = not pattern.startswith("!")
        assert not ignored, source


def test_the_default_image_is_the_one_that_does_everything() -> None:
    stages = read_dockerfile()
    assert list(stages)[-1] == "worker"
    wanted = re.findall(r"--from=(\S+)", DOCKERFILE.read_text("utf-8"))
    assert set(wanted) == {"build-api", "build-worker"} <= set(stages)


def test_the_base_is_pinned_to_a_python_that_is_promised() -> None:
    (argument,) = read_dockerfile()[""].all("ARG")
    found = re.fullmatch(r"PYTHON=(\d\.\d+)\.\d+-slim-bookworm@sha256:[0-9a-f]{64}", argument)
    assert found, argument
    assert f'"{found[1]}"' in (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
    assert {ancestry(target)[0].parent for target in TARGETS} == {"python:${PYTHON}"}


@pytest.mark.parametrize("target", TARGETS)
def test_the_command_exists(target: str) -> None:
    (entrypoint,), (command,) = instructions(target, "ENTRYPOINT"), instructions(target, "CMD")
    assert json.loads(entrypoint)[0] in PROJECT["project"]["scripts"]
    commands = getattr(typer.main.get_command(app), "commands", {})
    assert {json.loads(command)[0], "serve"} <= set(commands)


@pytest.mark.parametrize("target", TARGETS)
def test_the_user_is_not_root_and_may_write_where_it_has_to(target: str) -> None:
    (user,) = instructions(target, "USER")
    made = instructions(target, "RUN")[0]
    name = re.findall(r"useradd --uid 10001 .* (\w+) &&", made)[0]
    assert user == "10001:10001"
    assert f"--owner={name} --group={name}" in made
    places = json.loads(instructions(target, "VOLUME")[0])
    assert environment(target)[CACHE_VARIABLE] in places
    assert str(Path(environment(target)[KEYS_FILE]).parent) in places
    assert set(places) <= set(made.split())
    last = [each.name for each in ancestry(target)[-1].instructions]
    assert last[-2:] == ["USER", "CMD"]


@pytest.mark.parametrize("target", TARGETS)
def test_the_settings_of_the_image_are_settings(target: str) -> None:
    variables = {f"SNAPFIT_{name.upper()}" for name in Settings.model_fields}
    variables |= {f"SNAPFIT_SECURITY__{name.upper()}" for name in SecuritySettings.model_fields}
    own = {name for name in environment(target) if name.startswith("SNAPFIT_")}
    assert own - {CACHE_VARIABLE} == {"SNAPFIT_HOST", "SNAPFIT_PORT", KEYS_FILE} <= variables
    assert instructions(target, "EXPOSE") == [environment(target)["SNAPFIT_PORT"]]


@pytest.mark.parametrize("target", TARGETS)
def test_the_health_check_is_a_module_of_ours(target: str) -> None:
    (check,) = instructions(target, "HEALTHCHECK")
    python, option, module = json.loads(check.partition("CMD ")[2])
    assert (python, option) == ("python", "-m")
    room, name = module.removeprefix("snapfit.").split(".")
    assert (ROOT / room / f"{name}.py").is_file()


def test_what_the_api_image_installs_is_a_part_of_what_snapfit_needs() -> None:
    everything, api = requirements("worker"), requirements("api")
    assert everything == PROJECT["project"]["dependencies"]
    assert set(api) < set(everything)
    assert [it for it in api if it.startswith(TRACKING_STACK)] == []


def test_cameras_are_installed_by_their_extras() -> None:
    more = set(requirements("worker", "realsense,orbbec")) - set(requirements("worker"))
    assert {it.split(">")[0] for it in more} == {"pyrealsense2", "pyorbbecsdk2"}


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [(["worker", "webcam"], "no extra 'webcam'"), (["gpu"], "no image 'gpu'"), ([], "api, or")],
)
def test_what_cannot_be_installed_is_told(arguments: list[str], problem: str) -> None:
    script = str(ROOT / "docker" / "requirements.py")
    done = subprocess.run(
        [sys.executable, script, *arguments], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 1
    assert problem in done.stderr


def test_the_api_process_imports_only_what_its_image_has() -> None:
    """What `snapfit serve` imports with a Redis store, traced in a process of its own."""
    code = (
        "import sys\n"
        "from importlib.metadata import packages_distributions\n"
        "from snapfit.server.app import create_app\n"
        "from snapfit.server.settings import make_settings\n"
        "import snapfit.server.cli.main, snapfit.server.health, segno\n"
        "create_app(make_settings('here', {'store': 'redis://127.0.0.1:1/0'}))\n"
        "names = {name.partition('.')[0] for name in sys.modules}\n"
        "found = packages_distributions()\n"
        "print(*sorted({d.lower() for n in names for d in found.get(n, ())}))\n"
    )
    loaded = set(run(sys.executable, "-c", code).split())
    assert {"fastapi", "numpy", "redis", "uvicorn"} <= loaded
    assert [name for name in loaded if name.startswith(TRACKING_STACK)] == []
