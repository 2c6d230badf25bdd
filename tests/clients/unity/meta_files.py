"""Unity's .meta files: python tests/clients/unity/meta_files.py writes those that are missing.

Unity gives each file and folder a GUID by which scenes find it. A package that comes by Git cannot
be written to, so it must bring them. The GUID follows from the path at which the file was first
seen; a file that is moved takes its .meta along.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

PACKAGE = Path(__file__).parents[3] / "clients" / "unity" / "com.snapfit.client"

_END = "  externalObjects: {}\n  userData: \n  assetBundleName: \n  assetBundleVariant: \n"
_SCRIPT = (
    "MonoImporter:\n  externalObjects: {}\n  serializedVersion: 2\n  defaultReferences: []\n"
    "  executionOrder: 0\n  icon: {instanceID: 0}\n  userData: \n  assetBundleName: \n"
    "  assetBundleVariant: \n"
)
_IMPORTERS = {
    ".cs": _SCRIPT,
    ".asmdef": "AssemblyDefinitionImporter:\n" + _END,
    ".md": "TextScriptImporter:\n" + _END,
    ".json": "TextScriptImporter:\n" + _END,
}
_MANIFEST = "PackageManifestImporter:\n" + _END
_FOLDER = "folderAsset: yes\nDefaultImporter:\n" + _END


def assets() -> list[Path]:
    """Files and folders that need a .meta: all but hidden ones, and folders that end with ~."""
    return sorted(
        path
        for path in PACKAGE.rglob("*")
        if path.suffix != ".meta"
        and not path.name.startswith(".")
        and not path.name.endswith("~")
        and "Documentation~" not in path.parts
    )


def meta_of(path: Path) -> Path:
    """Where a file's .meta is."""
    return path.with_name(path.name + ".meta")


def text_for(path: Path) -> str:
    """What a new .meta says."""
    name = f"com.snapfit.client/{path.relative_to(PACKAGE).as_posix()}"
    guid = hashlib.md5(name.encode(), usedforsecurity=False).hexdigest()
    importer = _FOLDER if path.is_dir() else _IMPORTERS[path.suffix]
    if path == PACKAGE / "package.json":
        importer = _MANIFEST
    return f"fileFormatVersion: 2\nguid: {guid}\n{importer}"


def guid_in(meta: Path) -> str:
    """The GUID of a .meta."""
    found = re.search(r"^guid: ([0-9a-f]{32})$", meta.read_text(encoding="utf-8"), re.MULTILINE)
    assert found is not None, meta
    return found[1]


def main() -> None:
    """Write those that are missing."""
    for path in assets():
        if not meta_of(path).exists():
            meta_of(path).write_text(text_for(path), encoding="utf-8")


if __name__ == "__main__":
    main()
