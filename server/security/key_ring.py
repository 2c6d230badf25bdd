"""The keys as the running server sees them: it notices within a second what the file says."""

from __future__ import annotations

import asyncio
import hashlib
import logging
import secrets
import time
from collections import OrderedDict
from pathlib import Path

from snapfit.server.errors import KeyFileError
from snapfit.server.security.key_file import KeyRecord, KeyTable, read_keys
from snapfit.server.security.key_hash import id_of, is_key
from snapfit.server.security.session import session_key_id, sign_session

_LOOK_PERIOD_S = 1.0
_REMEMBERED = 1000
_LOG = logging.getLogger(__name__)


class KeyRing:
    """Tells whose key or session a request brings.

    The hash of a key takes tens of milliseconds by design, too long for 60 requests a second; so
    a key that was right once is remembered, as a digest that only this process can make.

    Args:
        path: the key file.

    Raises:
        KeyFileError: it cannot be read, or is no key file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._secret = secrets.token_bytes(32)
        self._right: OrderedDict[bytes, str] = OrderedDict()
        self._hashing = asyncio.Lock()  # one at a time: each takes 16 MiB and a core
        self._records: dict[str, KeyRecord] = {}
        self._stamp = self._stamp_now()
        self._use(read_keys(path) or KeyTable())
        self._looked_at_s = time.monotonic()

    def remembered(self, key: str) -> KeyRecord | None:
        """Whose key this is, if it was right before."""
        self._look()
        return self._records.get(self._right.get(self._digest(key), ""))

    async def of_key(self, key: str) -> KeyRecord | None:
        """Whose key this is; None for a wrong one. Another thread does the hashing."""
        key_id = id_of(key) or ""
        self._look(at_once=key_id not in self._records)  # it may have been added this moment
        record = self._records.get(key_id)
        if record is None:
            return None
        async with self._hashing:
            if self.remembered(key) is not None:
                return record
            if not await asyncio.to_thread(is_key, key, record.hash):
                return None
        self._right[self._digest(key)] = record.id
        if len(self._right) > _REMEMBERED:
            self._right.popitem(last=False)
        return record

    def of_session(self, token: str) -> KeyRecord | None:
        """Whose session this is; None where it is over, or never was one."""
        self._look()
        key_id = session_key_id(self._table.session_secret, token, time.time())
        return None if key_id is None else self._records.get(key_id)

    def new_session(self, record: KeyRecord) -> str:
        """A session token for the owner of this key."""
        return sign_session(self._table.session_secret, record.id, time.time())

    def holds(self, record: KeyRecord) -> bool:
        """Whether this key still is one."""
        self._look()
        return self._records.get(record.id) == record

    def _digest(self, key: str) -> bytes:
        return hashlib.blake2b(key.encode(), key=self._secret, digest_size=32).digest()

    def _look(self, *, at_once: bool = False) -> None:
        now_s = time.monotonic()
        if not at_once and now_s - self._looked_at_s < _LOOK_PERIOD_S:
            return
        self._looked_at_s = now_s
        stamp = self._stamp_now()
        if stamp == self._stamp:
            return
        try:
            self._use(read_keys(self._path) or KeyTable())
        except KeyFileError as error:
            _LOG.error("%s; the keys that were read last stay valid", error)
        self._stamp = stamp

    def _use(self, table: KeyTable) -> None:
        records = {record.id: record for record in table.keys}
        for digest, key_id in list(self._right.items()):
            if records.get(key_id) != self._records[key_id]:
                del self._right[digest]
        self._table = table
        self._records = records

    def _stamp_now(self) -> tuple[int, int] | None:
        try:
            status = self._path.stat()
        except OSError:
            return None
        return status.st_mtime_ns, status.st_ino
