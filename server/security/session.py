"""Session tokens: what a browser gets for its key, signed, so that no replica has to remember it.

`KEY_ID.EXPIRES_AT_S.SIGNATURE`, the signature HMAC-SHA256 with the key file's secret. A session
ends with its time, or when its key is removed.
"""

from __future__ import annotations

import hashlib
import hmac

COOKIE = "snapfit_session"
SESSION_S = 12 * 3600
"""How long a session lasts: a shift, seconds."""


def sign_session(secret: str, key_id: str, now_s: float) -> str:
    """A token for the key of this id, valid for `SESSION_S` from `now_s` (Unix time, seconds)."""
    payload = f"{key_id}.{int(now_s) + SESSION_S}"
    return f"{payload}.{_signature(secret, payload)}"


def session_key_id(secret: str, token: str, now_s: float) -> str | None:
    """The key id of a token that is genuine and still valid, else None."""
    payload, _, signature = token.rpartition(".")
    if not hmac.compare_digest(_signature(secret, payload).encode(), signature.encode()):
        return None
    key_id, _, expires_at_s = payload.partition(".")
    return key_id if now_s < int(expires_at_s) else None


def session_cookie(token: str, *, secure: bool) -> str:
    """The Set-Cookie value that gives a browser its session; an empty token ends it."""
    lifetime_s = SESSION_S if token else 0
    tail = "; Secure" if secure else ""
    return f"{COOKIE}={token}; Path=/; Max-Age={lifetime_s}; HttpOnly; SameSite=Strict{tail}"


def session_token(cookies: str) -> str | None:
    """The token in a Cookie header; None without one."""
    for pair in cookies.split(";"):
        name, _, value = pair.strip().partition("=")
        if name == COOKIE:
            return value
    return None


def _signature(secret: str, payload: str) -> str:
    return hmac.new(bytes.fromhex(secret), payload.encode(), hashlib.sha256).hexdigest()
