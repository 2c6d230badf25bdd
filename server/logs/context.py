"""Which request the code that runs now belongs to."""

from __future__ import annotations

import itertools
import re
import secrets
from contextvars import ContextVar

_RUN = secrets.token_hex(4)
_NUMBERS = itertools.count(1)
_GIVEN = re.compile(r"[A-Za-z0-9._-]{1,64}")

request_id: ContextVar[str | None] = ContextVar("request_id", default=None)
"""The id of the request in progress, None outside of one."""


def id_for_request(given: str | None) -> str:
    """The id that the client gave, if it is short and harmless, else a new one."""
    if given is not None and _GIVEN.fullmatch(given):
        return given
    return f"{_RUN}-{next(_NUMBERS):x}"
