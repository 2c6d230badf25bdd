"""ARLEM's two documents as files."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import urlsplit

from snapfit.server.arlem.activity import activity_of
from snapfit.server.arlem.addresses import Addresses
from snapfit.server.arlem.workplace import workplace_of
from snapfit.server.errors import ExportError, SettingsError
from snapfit.server.schemas_assembly import AssetInfo


def write_arlem(
    info: AssetInfo, folder: Path, server: str, station: str | None, language: str
) -> list[Path]:
    """Writes ASSET-workplace.json and ASSET-activity.json, which refer to each other so.

    Args:
        info: the asset in OpenCV's axes.
        folder: where they are written; made if it is not there.
        server: address of the snapfit server that players reach.
        station: whose assembly is followed; the server's only one if None.
        language: of the texts, ISO 639-1.

    Returns:
        What was written.

    Raises:
        NoStepsError: the asset has no steps.
        SettingsError: an address or a language that is none.
        ExportError: a file cannot be written.
    """
    _check(server, language)
    addresses = Addresses.of_files(server.rstrip("/"), info.asset, station)
    documents = {
        addresses.workplace: workplace_of(info, addresses),
        addresses.activity: activity_of(info, addresses, language),
    }
    written = []
    for name, document in documents.items():
        path = folder / name
        text = document.model_dump_json(by_alias=True, exclude_none=True, indent=2)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.write_text(f"{text}\n", encoding="utf-8")
        except OSError as error:
            problem = f"cannot be written ({error.strerror}): choose another --out"
            raise ExportError(path, problem) from error
        written.append(path)
    return written


def _check(server: str, language: str) -> None:
    parts = urlsplit(server)
    problems = []
    if parts.scheme not in ("http", "https") or not parts.netloc or parts.query or parts.fragment:
        problems.append(f"--server {server}: give an address such as http://192.168.0.10:8000")
    if not re.fullmatch("[a-z]{2}", language):
        problems.append(f"--language {language}: give two letters of ISO 639-1, such as en")
    if problems:
        raise SettingsError("the command line", problems)
