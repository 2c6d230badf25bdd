"""The package is laid out as Unity's package manager wants it; no C# is compiled here."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from meta_files import PACKAGE, assets, guid_in, meta_of

ROOT = PACKAGE.parents[2]
MANIFEST = json.loads((PACKAGE / "package.json").read_text(encoding="utf-8"))
DEFINITIONS = sorted(PACKAGE.rglob("*.asmdef"))
C_SHARP = [*sorted(PACKAGE.rglob("*.cs")), *sorted(Path(__file__).parent.rglob("*.cs"))]
PAGES = sorted(PACKAGE.rglob("*.md"))


def definition(path: Path) -> dict[str, Any]:
    read: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return read


def test_the_manifest_is_complete() -> None:
    assert MANIFEST["name"] == PACKAGE.name
    assert re.fullmatch(r"\d+\.\d+\.\d+", MANIFEST["version"])
    assert re.fullmatch(r"\d{4}\.\d", MANIFEST["unity"])
    assert MANIFEST["dependencies"] == {}
    for sample in MANIFEST["samples"]:
        assert (PACKAGE / sample["path"]).is_dir()
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'version = "{MANIFEST["version"]}"' in project


def test_licence_and_golden_vectors_are_the_projects_own() -> None:
    golden = PACKAGE / "Tests" / "Core" / "conventions.json"
    assert golden.read_bytes() == (ROOT / "openapi" / "conventions.json").read_bytes()
    assert (PACKAGE / "LICENSE.md").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert MANIFEST["license"] == "Apache-2.0"


def test_every_file_and_folder_has_its_own_guid() -> None:
    """Write those that are missing: python tests/clients/unity/meta_files.py."""
    guids: dict[str, Path] = {}
    for path in assets():
        meta = meta_of(path)
        assert meta.is_file(), f"{path} has no .meta"
        assert ("folderAsset: yes" in meta.read_text(encoding="utf-8")) == path.is_dir()
        assert guids.setdefault(guid_in(meta), path) == path
    assert len(guids) > 50


def test_no_meta_file_is_left_over() -> None:
    expected = {meta_of(path) for path in assets()}
    assert set(PACKAGE.rglob("*.meta")) == expected


def test_the_core_is_free_of_the_engine() -> None:
    core = definition(PACKAGE / "Runtime" / "Core" / "Snapfit.Core.asmdef")
    assert core["noEngineReferences"] is True
    assert core["references"] == []


def test_assemblies_refer_to_what_exists() -> None:
    names = {definition(path)["name"] for path in DEFINITIONS}
    assert len(names) == len(DEFINITIONS) == 4
    for path in DEFINITIONS:
        assert path.stem == definition(path)["name"]
        ours = [name for name in definition(path)["references"] if name.startswith("Snapfit")]
        assert set(ours) <= names
        assert not definition(path)["allowUnsafeCode"]


@pytest.mark.parametrize("path", C_SHARP, ids=lambda path: path.name)
def test_a_file_is_one_concept_of_its_name(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    assert len(lines) <= 400
    assert max(map(len, lines)) <= 100
    assert "\t" not in text
    assert "\r" not in text
    assert "Nullable" not in text
    first = path.stem in {"NUnit", "Attributes", "Numbers", "Objects", "Steps"} or re.search(
        rf"\b(?:class|struct|interface|enum) {path.stem}\b", text
    )
    assert first, "name it after what is in it: Unity finds scripts by their files' names"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_stay_in_the_package(page: Path) -> None:
    """It is installed without the rest of the repository."""
    text = page.read_text(encoding="utf-8")
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    anchors = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("#"):
            assert target[1:] in anchors, target
        elif not target.startswith("https://"):
            assert (page.parent / target).resolve().is_relative_to(PACKAGE)
            assert (page.parent / target).exists(), target


def test_the_readme_names_every_component() -> None:
    text = (PACKAGE / "README.md").read_text(encoding="utf-8")
    components = [
        path.stem
        for path in sorted((PACKAGE / "Runtime" / "Unity").glob("*.cs"))
        if re.search(rf"class {path.stem} : MonoBehaviour", path.read_text(encoding="utf-8"))
    ]
    assert len(components) == 6
    for name in components:
        assert f"`{name}`" in text
