"""How a ready-made answer becomes a response."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import Response

from snapfit.server.answers import Answer


def reply(answer: Answer, now_us: int, if_none_match: str | None, *, is_new: bool) -> Response:
    """200 with the JSON, 304 where the client has it, 204 where it waited in vain."""
    headers = {"ETag": answer.etag.decode(), "Cache-Control": "no-store"}
    if if_none_match is not None and answer.matches(if_none_match.encode()):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    if not is_new:
        return Response(status_code=HTTPStatus.NO_CONTENT, headers=headers)
    return Response(answer.body(now_us), headers=headers, media_type="application/json")
