"""The house itself: packages, version, sizes, and the promises of its files."""

import importlib.metadata
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("models", "tracking", "server", "clients")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
SOURCES = [path for room in (*ROOMS, "tests") for path in sorted((ROOT / room).rglob("*.py"))]


def test_every_package_is_listed() -> None:
    folders = {
        f"snapfit.{path.parent.relative_to(ROOT).as_posix().replace('/', '.')}"
        for room in ROOMS
        for path in (ROOT / room).rglob("__init__.py")
    }
    assert folders == set(PROJECT["tool"]["setuptools"]["packages"])


def test_every_folder_with_code_is_a_package() -> None:
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            assert (path.parent / "__init__.py").is_file(), path


def test_the_name_snapfit_itself_holds_nothing() -> None:
    assert not (ROOT / "snapfit" / "__init__.py").exists()


def test_the_installed_version_is_the_projects() -> None:
    assert importlib.metadata.version("snapfit") == PROJECT["project"]["version"]


def test_every_room_is_typed_and_says_so_when_installed() -> None:
    data = PROJECT["tool"]["setuptools"]["package-data"]
    for room in ROOMS:
        assert (ROOT / room / "py.typed").is_file()
        assert "py.typed" in data[f"snapfit.{room}"]


def test_packaged_data_patterns_match_something() -> None:
    """A pattern that matches nothing is a file that an installed snapfit would miss."""
    data = PROJECT["tool"]["setuptools"]["package-data"]
    bundles = [path.parent for path in (ROOT / "models").glob("assets/*/asset.toml")]
    assert bundles
    patterns = [pattern for pattern in data["snapfit.models"] if pattern.startswith("assets/")]
    packed = {path for pattern in patterns for path in (ROOT / "models").glob(pattern)}
    for bundle in bundles:
        left_out = {path for path in bundle.iterdir() if path.is_file()} - packed
        assert not left_out, f"add to package-data: {left_out}"


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_file_is_too_long(path: Path) -> None:
    n_lines = len(path.read_text(encoding="utf-8").splitlines())
    assert n_lines <= 400, f"{n_lines} lines: split it by concept"


def test_the_licence_is_the_one_that_is_declared() -> None:
    text = (ROOT / "LICENSE").read_text()
    assert PROJECT["project"]["license"] == "Apache-2.0"
    assert "Apache License" in text
    assert "Version 2.0, January 2004" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_ci_runs_every_python_that_is_promised() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text()
    assert PROJECT["project"]["requires-python"] == ">=3.11,<3.14"
    assert re.search(r'python: \["3\.11", "3\.12", "3\.13"\]', workflow)
    assert "bash .ci/run" in workflow
    script = (ROOT / ".ci" / "run").read_text()
    assert "set -euo pipefail" in script
    assert script.rstrip().endswith("make test")


@pytest.mark.parametrize("name", ["run", "audit", "page"])
def test_what_ci_runs_is_a_script_that_bash_understands(name: str) -> None:
    script = ROOT / ".ci" / name
    assert script.stat().st_mode & 0o111
    done = subprocess.run(["bash", "-n", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_changelog_has_a_place_for_what_comes() -> None:
    lines = (ROOT / "CHANGELOG.md").read_text().splitlines()
    assert lines[0] == "# Changelog"
    assert any(line.startswith("## [Unreleased]") for line in lines)
