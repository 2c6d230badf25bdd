"""Sessions: a browser changes its key for a cookie, since its pictures and streams carry no key."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.problems import problem_responses
from snapfit.server.security.access import Access
from snapfit.server.security.asking import Asking
from snapfit.server.security.refusals import refusal, wrong_key
from snapfit.server.security.session import SESSION_S, session_cookie

router = APIRouter(tags=["session"])


class SessionWish(BaseModel):
    """A key, to be changed for a session."""

    model_config = ConfigDict(extra="forbid")

    key: str = Field(min_length=1, max_length=200, description="An API key.")


class SessionInfo(BaseModel):
    """What a session is good for."""

    role: str = Field(description="read, or operate, which includes reading.")
    lasts_s: int = Field(description="Seconds until it ends; then ask again.")


_REFUSED = (
    HTTPStatus.BAD_REQUEST,
    HTTPStatus.UNAUTHORIZED,
    HTTPStatus.TOO_MANY_REQUESTS,
    HTTPStatus.UNPROCESSABLE_ENTITY,
)


@router.post("/session", response_model=SessionInfo, responses=problem_responses(*_REFUSED))
async def post_session(request: Request, response: Response, wish: SessionWish) -> object:
    """Begin a session: the answer sets a cookie that pages of this server alone can use."""
    access: Access = request.app.state.access
    if access.ring is None:  # no key is needed here: everybody may operate
        return SessionInfo(role="operate", lasts_s=SESSION_S)
    record = await access.owner(access.ring, wish.key, Asking.of(request.scope).address)
    if record is None:
        return refusal(request.scope["path"], wrong_key())
    token = access.ring.new_session(record)
    secure = request.scope["scheme"] == "https"
    response.headers["Set-Cookie"] = session_cookie(token, secure=secure)
    response.headers["Cache-Control"] = "no-store"
    return SessionInfo(role=record.role, lasts_s=SESSION_S)


@router.delete("/session", status_code=HTTPStatus.NO_CONTENT)
async def delete_session(request: Request) -> Response:
    """End this browser's session."""
    cookie = session_cookie("", secure=request.scope["scheme"] == "https")
    return Response(status_code=HTTPStatus.NO_CONTENT, headers={"Set-Cookie": cookie})
