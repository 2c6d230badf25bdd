"""An asset's files in Redis: a hash with a list of them, and each one in pieces."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, field_validator

LIST = "files"
"""The field with the list."""

PIECE_BYTES = 256 * 1024
"""So small that no piece takes a second, whatever the network, and poses wait for none."""

LARGEST_FILE_BYTES = 32 * 1024 * 1024
LARGEST_ASSET_BYTES = 128 * 1024 * 1024

# As `export_asset` names folders and files: an asset and its digest; one folder deep at most.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*-[0-9a-f]{16}")
_PATH = re.compile(r"([A-Za-z0-9_-]+/)?(?!\.{1,2}$)[^/\\\x00-\x1f]{1,255}")


class StoredFile(BaseModel):
    """One of them.

    Attributes:
        path: in the asset's folder.
        size_bytes, sha256: of its content.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    path: str
    size_bytes: int = Field(ge=0, le=LARGEST_FILE_BYTES)
    sha256: str

    @field_validator("path")
    @classmethod
    def _stays_inside(cls, value: str) -> str:
        """Whoever can write to Redis does not write beside the folder."""
        if _PATH.fullmatch(value) is None:
            raise ValueError("is no file of an exported asset")
        return value

    def fields(self) -> list[str]:
        """The names of its pieces."""
        count = -(-self.size_bytes // PIECE_BYTES)
        return [f"{self.path}\n{number}" for number in range(count)]

    def holds(self, content: bytes) -> bool:
        """Whether this is its content."""
        return hashlib.sha256(content).hexdigest() == self.sha256


class StoredAsset(BaseModel):
    """The list of the files."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    files: tuple[StoredFile, ...]

    @property
    def size_bytes(self) -> int:
        """Of all of them."""
        return sum(file.size_bytes for file in self.files)


def asset_key(name: str) -> str:
    """Where an asset's files are, for all stations that assemble it."""
    return f"snapfit:asset:{name}"


def asset_name(folder: str) -> str | None:
    """The name of an exported asset, from its folder on a machine of any system; None for none."""
    name = re.split(r"[/\\]", folder)[-1]
    return name if _NAME.fullmatch(name) else None


def stored_file(folder: Path, file: Path, content: bytes) -> StoredFile:
    """A file as it is listed."""
    return StoredFile(
        path=file.relative_to(folder).as_posix(),
        size_bytes=len(content),
        sha256=hashlib.sha256(content).hexdigest(),
    )
