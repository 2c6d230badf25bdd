"""Pictures: what the camera sees, plain or with the parts drawn in."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Response

from snapfit.server.pose_store import Picture
from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import OneStation
from snapfit.server.station import Station

router = APIRouter(tags=["pictures"])

_JPEG = "image/jpeg"
_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "A JPEG; the header Captured-At-Us tells the exposure of its frame.",
        "content": {_JPEG: {"schema": {"type": "string", "format": "binary"}}},
    },
    **problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.SERVICE_UNAVAILABLE),
}


@router.get("/frame.jpg", response_class=Response, responses=_RESPONSES)
async def get_frame(station: OneStation) -> Response:
    """What the camera sees."""
    return await _picture(station, Picture.FRAME)


@router.get("/overlay.jpg", response_class=Response, responses=_RESPONSES)
async def get_overlay(station: OneStation) -> Response:
    """What the camera sees, with the tracked parts drawn in."""
    return await _picture(station, Picture.OVERLAY)


async def _picture(station: Station, kind: Picture) -> Response:
    picture = await station.picture(kind)
    headers = {"Cache-Control": "no-store", "Captured-At-Us": str(picture.captured_at_us)}
    return Response(picture.jpeg, headers=headers, media_type=_JPEG)
