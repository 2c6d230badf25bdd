"""Pictures: what the camera sees, plain or with the parts drawn in."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Response

from snapfit.server.picture_message import PictureMessage
from snapfit.server.pose_store import Picture
from snapfit.server.problems import ProblemError, problem_responses
from snapfit.server.routes.dependencies import OneStation
from snapfit.server.station import Station
from snapfit.server.stream_response import StreamResponse

router = APIRouter(tags=["pictures"])

_JPEG = "image/jpeg"
_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "A JPEG; the header Captured-At-Us tells the exposure of its frame.",
        "content": {_JPEG: {"schema": {"type": "string", "format": "binary"}}},
    },
    **problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.SERVICE_UNAVAILABLE),
}
_MJPEG = "multipart/x-mixed-replace; boundary=frame"
_PART = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\nCaptured-At-Us: %d\r\n\r\n"
_WAIT_S = 1.0
_FILM: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "Motion JPEG: one JPEG after the other, at most 15 a second; a slow client "
        "gets fewer.",
        "content": {"multipart/x-mixed-replace": {"schema": {"type": "string"}}},
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


@router.get("/frame.mjpeg", response_class=Response, responses=_FILM)
async def get_frames(station: OneStation) -> Response:
    """What the camera sees, as it goes on."""
    return await _film(station, Picture.FRAME)


@router.get("/overlay.mjpeg", response_class=Response, responses=_FILM)
async def get_overlays(station: OneStation) -> Response:
    """What the camera sees, with the tracked parts drawn in, as it goes on."""
    return await _film(station, Picture.OVERLAY)


async def _film(station: Station, kind: Picture) -> Response:
    first = await station.picture(kind)  # a problem while it can still be told
    return StreamResponse(_frames(station, kind, first), _MJPEG)


async def _frames(station: Station, kind: Picture, picture: PictureMessage) -> AsyncIterator[bytes]:
    """The latest picture whenever the client has taken the last one."""
    sent = -1
    while not station.watch.is_ending:
        if picture.generation != sent:
            sent = picture.generation
            yield _PART % (len(picture.jpeg), picture.captured_at_us) + picture.jpeg + b"\r\n"
        await station.watch.change(_WAIT_S)
        if not station.watch.is_ending:  # there may be no other picture to wait for
            with contextlib.suppress(ProblemError):  # the worker may come back
                picture = await station.picture(kind)


async def _picture(station: Station, kind: Picture) -> Response:
    picture = await station.picture(kind)
    headers = {"Cache-Control": "no-store", "Captured-At-Us": str(picture.captured_at_us)}
    return Response(picture.jpeg, headers=headers, media_type=_JPEG)
