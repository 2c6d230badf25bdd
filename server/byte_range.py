"""The header Range of a request for a file: one range is served, what is none is passed over."""

from __future__ import annotations

import re
from http import HTTPStatus

from starlette.types import Scope

from snapfit.server.problems import ProblemError

_RANGE = b"range"
_ONE = re.compile(rb"bytes=(?:([0-9]{1,18})-([0-9]{0,18})|-([0-9]{1,18}))")


def leave_one_range(scope: Scope, n_bytes: int) -> None:
    """Takes the header out of the scope unless it asks for one range (RFC 9110, 14.2).

    Several ranges, which no player of films asks for, are answered with the whole file.

    Args:
        scope: of the request.
        n_bytes: length of the file.

    Raises:
        ProblemError: 416, the range lies beyond the file.
    """
    told = [value for name, value in scope["headers"] if name == _RANGE]
    if not told:
        return
    found = _ONE.fullmatch(told[0].strip()) if len(told) == 1 else None
    if found is None or _is_backwards(found):
        scope["headers"] = [each for each in scope["headers"] if each[0] != _RANGE]
        return
    first, _, last_bytes = found.groups()
    is_beyond = int(first) >= n_bytes if first is not None else int(last_bytes) == 0
    if is_beyond or n_bytes == 0:
        raise ProblemError(
            HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE,
            "beyond-the-file",
            f"The file has {n_bytes} bytes, none of them in this range.",
            bytes=n_bytes,
        )


def _is_backwards(found: re.Match[bytes]) -> bool:
    first, last, _ = found.groups()
    return bool(first and last) and int(last) < int(first)
