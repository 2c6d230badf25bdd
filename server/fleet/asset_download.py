"""Brings a station's asset from Redis into the cache of a replica's machine."""

from __future__ import annotations

import logging
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import redis

from snapfit.models.cache import cache_directory
from snapfit.server.asset_paths import INFO_NAME
from snapfit.server.fleet.asset_files import (
    LARGEST_ASSET_BYTES,
    LIST,
    StoredAsset,
    StoredFile,
    asset_key,
    asset_name,
)

_AGAIN_S = 0.5
_LONG_AGAIN_S = 60.0
_DONE = object()
_LOG = logging.getLogger(__name__)


class AssetDownload:
    """Fetches an asset piece by piece, so that poses never wait for a film.

    Attributes:
        folder: of the asset on this machine; None until it is whole.
    """

    def __init__(self) -> None:
        self.folder: Path | None = None
        self._name: str | None = None
        self._work: Iterator[object] | None = None
        self._try_at_s = 0.0
        self._has_complained = False

    def connected(self) -> None:
        """Another connection: what was begun is begun anew."""
        self._work = None

    def serve(self, folder: str | None) -> None:
        """The folder on the worker's machine, as the worker reports it."""
        name = None if folder is None else asset_name(folder)
        if name != self._name:
            self._name, self.folder = name, None
            self._work, self._try_at_s = None, 0.0

    def step(self, client: redis.Redis) -> bool:
        """Fetch a piece, if there is one left; whether the asset is whole now and was not."""
        if self._name is None or self.folder is not None:
            return False
        if self._work is None:
            if time.monotonic() < self._try_at_s:
                return False
            self._work = self._download(client, self._name)
        wait_s = _AGAIN_S
        try:
            is_done = next(self._work, _DONE) is _DONE
        except (OSError, ValueError) as error:
            self._complain(str(error))
            is_done, wait_s = True, _LONG_AGAIN_S
        if is_done:
            self._work, self._try_at_s = None, time.monotonic() + wait_s
        return self.folder is not None

    def _download(self, client: redis.Redis, name: str) -> Iterator[object]:
        """Whole or not at all: beside until it is.

        Raises:
            OSError: the cache cannot be written.
            ValueError: what Redis holds is no asset.
        """
        folder = cache_directory() / "assets" / name
        if not (folder / INFO_NAME).is_file():
            listed: object = client.hget(asset_key(name), LIST)
            if not isinstance(listed, bytes):  # not handed over yet
                return
            asset = StoredAsset.model_validate_json(listed)
            if asset.size_bytes > LARGEST_ASSET_BYTES:
                raise ValueError(f"{asset.size_bytes >> 20} MiB are too much for an asset")
            folder.parent.mkdir(parents=True, exist_ok=True)
            beside = Path(tempfile.mkdtemp(prefix=".fetching-", dir=folder.parent))
            try:
                for file in asset.files:
                    yield from _fetch(client, asset_key(name), beside, file)
                _put_in_place(beside, folder)
            finally:
                shutil.rmtree(beside, ignore_errors=True)
        self.folder = folder

    def _complain(self, problem: str) -> None:
        if not self._has_complained:
            self._has_complained = True
            _LOG.warning(
                "asset %s: its steps and meshes cannot be served: %s; $SNAPFIT_CACHE tells where "
                "they are kept",
                self._name,
                problem,
            )


def _fetch(client: redis.Redis, key: str, folder: Path, file: StoredFile) -> Iterator[object]:
    """One file, piece by piece."""
    pieces = []
    for field in file.fields():
        piece: object = client.hget(key, field)
        pieces.append(piece if isinstance(piece, bytes) else b"")
        yield None
    content = b"".join(pieces)
    if not file.holds(content):
        raise ValueError(f"{file.path} is not the file that was handed over")
    path = folder / file.path
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)


def _put_in_place(beside: Path, folder: Path) -> None:
    try:
        beside.rename(folder)
    except OSError:
        if not (folder / INFO_NAME).is_file():  # another replica of this machine was first
            raise
