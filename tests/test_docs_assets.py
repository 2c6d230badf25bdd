"""The page of the bundled assets: each with its own graph and a small picture."""

import re
from pathlib import Path

import cv2
import pytest

from snapfit.models.asset import bundled_names, find_asset
from snapfit.server.cli.asset import mermaid

DOCS = Path(__file__).parents[1] / "docs"
PICTURE_BYTES = 60_000


def sections() -> dict[str, str]:
    text = (DOCS / "assets.md").read_text(encoding="utf-8")
    parts = re.split(r"^## (.+)$", text, flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def test_every_bundled_asset_has_its_section() -> None:
    assert set(sections()) == {find_asset(name).title for name in bundled_names()}


@pytest.mark.parametrize("name", bundled_names())
def test_graph_and_picture_are_those_of_the_asset(name: str) -> None:
    asset = find_asset(name)
    section = sections()[asset.title]
    (graph,) = re.findall(r"```mermaid\n(.*?)\n```", section, re.DOTALL)
    assert graph == mermaid(asset), f"snapfit asset check {name} prints the graph anew"
    (picture,) = re.findall(r"\]\((pictures/[\w.-]+)\)", section)
    assert name in picture
    path = DOCS / picture
    assert path.stat().st_size < PICTURE_BYTES
    assert min(cv2.imread(str(path)).shape[:2]) > 300
