"""Where the files of an exported asset lie, and at which paths they are served."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

INFO_NAME = "asset.json"


def part_file(folder: Path, part: str) -> Path:
    """The glTF binary of a part."""
    return folder / "parts" / f"{part}.glb"


def part_path(asset: str, part: str) -> str:
    """The path that serves it."""
    return f"/v1/assets/{quote(asset)}/parts/{quote(part)}.glb"


def media_file(folder: Path, name: str) -> Path:
    """A picture or film that a step names; flat, so that no name leads out of the folder."""
    return folder / "media" / quote(name, safe="")


def media_path(asset: str, name: str) -> str:
    """The path that serves it."""
    return f"/v1/assets/{quote(asset)}/media/{quote(name)}"
