"""The built page as it is committed: whole, small, and fit for the server's security headers."""

from __future__ import annotations

import gzip
import json
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WEB = ROOT / "clients" / "web"
DIST = WEB / "dist"
MOST_BYTES = 1_000_000
PAGES = ("index.html", "docs.html")


@pytest.mark.parametrize("name", PAGES)
def test_a_page_loads_its_own_files_alone_and_has_nothing_inline(name: str) -> None:
    page = (DIST / name).read_text(encoding="utf-8")
    assert re.findall(r"<script(?![^>]*\bsrc=)", page) == []
    assert re.findall(r"<style|\sstyle=|\son\w+=", page) == []
    loaded = re.findall(r'<(?:script|link|img)\b[^>]*?\b(?:src|href)="([^"]+)"', page)
    assert len(loaded) >= 3
    for address in loaded:
        assert address.startswith("./")
        assert (DIST / address).is_file(), address


def test_it_is_small_when_it_is_sent() -> None:
    sizes = [len(gzip.compress(path.read_bytes())) for path in DIST.iterdir()]
    assert sum(sizes) < MOST_BYTES


def test_the_wheel_has_all_of_it() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"]["snapfit.clients.web"]
    packed = {path for pattern in patterns for path in WEB.glob(pattern)}
    assert packed == {path for path in DIST.rglob("*") if path.is_file()}


def test_what_it_is_built_with_is_pinned() -> None:
    package = json.loads((WEB / "package.json").read_text(encoding="utf-8"))
    lock = json.loads((WEB / "package-lock.json").read_text(encoding="utf-8"))["packages"]
    wanted = {**package["dependencies"], **package["devDependencies"]}
    assert list(package["dependencies"]) == ["three"]
    for name, version in wanted.items():
        assert lock[f"node_modules/{name}"]["version"] == version


def test_no_module_is_too_long() -> None:
    # The contract's types are made from openapi.json, and not committed.
    modules = [path for path in (WEB / "src").rglob("*.ts") if path.name != "contract.d.ts"]
    assert len(modules) > 20
    assert [path for path in modules if len(path.read_text("utf-8").splitlines()) > 250] == []
