"""The key file: names, roles and hashes of the keys, and the secret that signs sessions.

No key stands in it. It is written whole or not at all, and only its owner may read it.
"""

from __future__ import annotations

import os
import secrets
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import platformdirs
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from snapfit.server.errors import KeyFileError
from snapfit.server.security.key_hash import hash_key, id_of, new_key
from snapfit.server.security.roles import Role

KEY_NAME = r"^[A-Za-z0-9][A-Za-z0-9._ -]{0,63}$"


class KeyRecord(BaseModel):
    """What is known of a key."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str = Field(pattern=r"^[0-9a-f]{8}$")
    name: str = Field(pattern=KEY_NAME)
    role: Role
    hash: str = Field(pattern=r"^scrypt\$\d+\$\d+\$\d+\$[0-9a-f]+\$[0-9a-f]+$")
    created_at: str


class KeyTable(BaseModel):
    """All that the file holds."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    version: int = Field(default=1, ge=1, le=1)
    session_secret: str = Field(default_factory=lambda: secrets.token_hex(32), min_length=64)
    keys: tuple[KeyRecord, ...] = ()


def default_key_file() -> Path:
    """Where keys are kept unless `security.keys_file` tells."""
    return Path(platformdirs.user_config_dir("snapfit")) / "keys.json"


def read_keys(path: Path) -> KeyTable | None:
    """The table; None where there is no file yet.

    Raises:
        KeyFileError: it cannot be read, or is no key file.
    """
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise KeyFileError(path, f"cannot be read: {error.strerror}") from error
    try:
        return KeyTable.model_validate_json(text)
    except ValidationError as error:
        # Without the values: hashes and secrets belong into no log.
        where = ".".join(str(step) for step in error.errors(include_input=False)[0]["loc"])
        raise KeyFileError(path, f"is no key file: {where or 'it is no JSON'}") from error


def add_key(path: Path, name: str, role: Role) -> str:
    """Add a key to the file, which is made if need be; the key itself, which nobody can see again.

    Raises:
        KeyFileError: the name is taken or no name, or the file cannot be read or written.
    """
    key = new_key()
    with _locked(path):
        table = read_keys(path) or KeyTable()
        if any(record.name == name for record in table.keys):
            raise KeyFileError(path, f"has a key named {name!r} already: remove it first")
        created_at = datetime.now(UTC).isoformat(timespec="seconds")
        try:
            record = KeyRecord(
                id=id_of(key) or "", name=name, role=role, hash=hash_key(key), created_at=created_at
            )
        except ValidationError as error:
            problem = f"{name!r} is no name: letters, digits, dot, dash, underscore, space"
            raise KeyFileError(path, problem) from error
        _write(path, table.model_copy(update={"keys": (*table.keys, record)}))
    return key


def remove_key(path: Path, name: str) -> None:
    """Remove the key of this name or id.

    Raises:
        KeyFileError: there is none, or the file cannot be read or written.
    """
    with _locked(path):
        table = read_keys(path) or KeyTable()
        left = tuple(record for record in table.keys if name not in (record.name, record.id))
        if len(left) == len(table.keys):
            known = ", ".join(record.name for record in table.keys) or "none"
            raise KeyFileError(path, f"has no key {name!r}; it has {known}")
        _write(path, table.model_copy(update={"keys": left}))


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Two commands at once do not lose each other's key."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with path.with_suffix(".lock").open("w") as lock:
            if sys.platform != "win32":
                import fcntl  # which Windows has not; there, one command at a time has to do

                fcntl.flock(lock, fcntl.LOCK_EX)
            yield
    except OSError as error:
        problem = f"cannot be written: {error.strerror}; set security.keys_file to another place"
        raise KeyFileError(path, problem) from error


def _write(path: Path, table: KeyTable) -> None:
    new = path.with_suffix(".new")
    new.unlink(missing_ok=True)
    descriptor = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(table.model_dump_json(indent=2) + "\n")
        file.flush()
        os.fsync(file.fileno())
    new.replace(path)
