"""Links between our pages lead somewhere; examples in JSON and TOML can be parsed."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    ROOT / "docker" / "README.md",
]
PICTURE_BYTES = 150_000


def links(page: Path) -> list[str]:
    """Targets of links and pictures inside the repository."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    return [target for target in targets if not re.match(r"https?://|mailto:", target)]


def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives to a page's headings."""
    titles = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def is_broken(page: Path, link: str) -> bool:
    name, _, anchor = link.partition("#")
    target = (page.parent / name).resolve() if name else page
    if not target.exists() or not target.is_relative_to(ROOT):
        return True
    return bool(anchor) and anchor not in anchors(target)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_resolve(page: Path) -> None:
    assert [link for link in links(page) if is_broken(page, link)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_examples_are_well_formed(page: Path) -> None:
    for language, parse in (("json", json.loads), ("toml", tomllib.loads)):
        for example in re.findall(rf"```{language}\n(.*?)```", page.read_text("utf-8"), re.DOTALL):
            assert parse(example)


def test_every_page_can_be_reached_from_the_readme() -> None:
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached:
            continue
        reached.add(page)
        targets = [(page.parent / link.partition("#")[0]).resolve() for link in links(page)]
        waiting += [target for target in targets if target.suffix == ".md" and target.is_file()]
    assert set(PAGES) - reached == set()


def test_the_picture_is_small() -> None:
    content = (ROOT / "docs" / "overlay.jpg").read_bytes()
    assert content.startswith(b"\xff\xd8")
    assert len(content) < PICTURE_BYTES


def test_a_broken_link_is_noticed(tmp_path: Path) -> None:
    assert is_broken(ROOT / "README.md", "docs/no-such-page.md")
    assert is_broken(ROOT / "README.md", "#no-such-heading")
    assert is_broken(ROOT / "README.md", str(tmp_path))
    assert not is_broken(ROOT / "README.md", "#limits")


def test_the_api_tells_where_the_conventions_are() -> None:
    document = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
    (page,) = re.findall(r"`(docs/[\w.]+)`", document["info"]["description"])
    assert (ROOT / page).is_file()
