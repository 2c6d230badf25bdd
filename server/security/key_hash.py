"""API keys: made, hashed, compared.

A key is `sf_ID_SECRET`: the id names its line in the key file and is no secret, the secret has
256 random bits. At rest there is only scrypt (RFC 7914) of the whole key with a salt of its own.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets

_COST, _BLOCK, _LANES = 2**14, 8, 1  # 16 MiB and some 40 ms a try
_SALT_BYTES, _HASH_BYTES = 16, 32
_MEMORY_LIMIT = 64 * 1024 * 1024
_KEY = re.compile(r"sf_([0-9a-f]{8})_([A-Za-z0-9_-]{43})")


def new_key() -> str:
    """A new random key."""
    return f"sf_{secrets.token_hex(4)}_{secrets.token_urlsafe(32)}"


def id_of(key: str) -> str | None:
    """The id in a key; None for what does not look like a key at all."""
    match = _KEY.fullmatch(key)
    return None if match is None else match[1]


def hash_key(key: str) -> str:
    """What is stored of a key: `scrypt$cost$block$lanes$salt$hash`, salt and hash in hex."""
    salt = secrets.token_bytes(_SALT_BYTES)
    digest = _scrypt(key, salt, _COST, _BLOCK, _LANES)
    return f"scrypt${_COST}${_BLOCK}${_LANES}${salt.hex()}${digest.hex()}"


def is_key(key: str, stored: str) -> bool:
    """Whether this is the key whose hash is stored; compares in constant time.

    Raises:
        ValueError: `stored` was not made by `hash_key`.
    """
    name, cost, block, lanes, salt, digest = stored.split("$")
    if name != "scrypt":
        raise ValueError(f"unknown hash {name!r}")
    tried = _scrypt(key, bytes.fromhex(salt), int(cost), int(block), int(lanes))
    return hmac.compare_digest(tried, bytes.fromhex(digest))


def _scrypt(key: str, salt: bytes, cost: int, block: int, lanes: int) -> bytes:
    return hashlib.scrypt(
        key.encode(), salt=salt, n=cost, r=block, p=lanes, maxmem=_MEMORY_LIMIT, dklen=_HASH_BYTES
    )
