"""Puts what an API may serve of an asset into Redis, once; runs on the worker's machine."""

from __future__ import annotations

import logging
import secrets
import time
from collections.abc import Iterator
from pathlib import Path

import redis

from snapfit.server.fleet.asset_files import (
    LARGEST_ASSET_BYTES,
    LARGEST_FILE_BYTES,
    LIST,
    PIECE_BYTES,
    StoredAsset,
    asset_key,
    asset_name,
    stored_file,
)
from snapfit.server.fleet.keys import KEPT_S

_MAKING_S = 60
_REFRESH_S = 60.0
_DONE = object()
_LOG = logging.getLogger(__name__)


class AssetUpload:
    """Hands an asset over piece by piece, so that poses never wait for a film."""

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._work: Iterator[object] | None = None
        self._done_at_s = 0.0
        self._told_of: set[Path] = set()

    def connected(self) -> None:
        """Another connection: Redis may have lost it."""
        self._work = None
        self._done_at_s = 0.0

    def serve(self, folder: str | None) -> None:
        """The folder that the worker has exported its asset to."""
        wanted = None if folder is None or asset_name(folder) is None else Path(folder)
        if wanted != self._folder:
            self._folder = wanted
            self.connected()

    def step(self, client: redis.Redis) -> None:
        """Hand over a piece, if there is one left."""
        folder = self._folder
        if folder is None:
            return
        if self._work is None:
            if time.monotonic() - self._done_at_s < _REFRESH_S:
                return
            self._work = self._upload(client, folder)
        try:
            is_done = next(self._work, _DONE) is _DONE
        except (OSError, ValueError) as error:
            self._complain(folder, f"its files cannot be handed over: {error}")
            is_done = True
        if is_done:
            self._work, self._done_at_s = None, time.monotonic()

    def _upload(self, client: redis.Redis, folder: Path) -> Iterator[object]:
        """Whole or not at all: under another name until it is."""
        key = asset_key(folder.name)
        if client.expire(key, KEPT_S):
            return
        making = f"{key}:{secrets.token_hex(6)}"
        listed = StoredAsset(files=())
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            if not self._fits(file, listed):
                continue
            content = file.read_bytes()
            stored = stored_file(folder, file, content)
            for number, field in enumerate(stored.fields()):
                piece = content[number * PIECE_BYTES : (number + 1) * PIECE_BYTES]
                client.hset(making, field, piece)  # type: ignore[arg-type]  # bytes are a value
                client.expire(making, _MAKING_S)
                yield None
            listed = StoredAsset(files=(*listed.files, stored))
        pipeline = client.pipeline()
        pipeline.hset(making, LIST, listed.model_dump_json())
        pipeline.rename(making, key)
        pipeline.expire(key, KEPT_S)
        pipeline.execute()

    def _fits(self, file: Path, listed: StoredAsset) -> bool:
        size_bytes = file.stat().st_size
        if size_bytes > LARGEST_FILE_BYTES:
            self._complain(file, f"is larger than {LARGEST_FILE_BYTES >> 20} MiB")
            return False
        if listed.size_bytes + size_bytes > LARGEST_ASSET_BYTES:
            self._complain(file, f"goes over the {LARGEST_ASSET_BYTES >> 20} MiB of an asset")
            return False
        return True

    def _complain(self, what: Path, problem: str) -> None:
        if what not in self._told_of:
            self._told_of.add(what)
            _LOG.warning(
                "%s: %s: other machines cannot serve it; name a film by its web address",
                what,
                problem,
            )
