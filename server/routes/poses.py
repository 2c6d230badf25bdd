"""Poses: of all parts, of one part."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Depends, Request, Response

from snapfit.server.answers import Answer
from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import (
    IfNoneMatch,
    NamedStation,
    OnlyStation,
    PartName,
    check_query,
)
from snapfit.server.schemas import PartSnapshot, PoseSnapshot

router = APIRouter(tags=["poses"], dependencies=[Depends(check_query)])

_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.NOT_MODIFIED.value: {"description": "Nothing changed since If-None-Match."},
    **problem_responses(
        HTTPStatus.NOT_FOUND, HTTPStatus.UNPROCESSABLE_ENTITY, HTTPStatus.SERVICE_UNAVAILABLE
    ),
}


@router.get("/stations/{station}/poses", response_model=PoseSnapshot, responses=_RESPONSES)
async def get_station_poses(
    request: Request,
    station: NamedStation,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """The poses of all parts in the latest frame."""
    return _reply(request, station.poses(), if_none_match)


@router.get("/stations/{station}/poses/{part}", response_model=PartSnapshot, responses=_RESPONSES)
async def get_station_part_pose(
    request: Request,
    station: NamedStation,
    part: PartName,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """The pose of one part in the latest frame."""
    return _reply(request, station.part(part), if_none_match)


@router.get("/poses", response_model=PoseSnapshot, responses=_RESPONSES)
async def get_poses(
    request: Request,
    station: OnlyStation,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """The poses of all parts in the latest frame of the only station."""
    return _reply(request, station.poses(), if_none_match)


@router.get("/poses/{part}", response_model=PartSnapshot, responses=_RESPONSES)
async def get_part_pose(
    request: Request,
    station: OnlyStation,
    part: PartName,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """The pose of one part in the latest frame of the only station."""
    return _reply(request, station.part(part), if_none_match)


def _reply(request: Request, answer: Answer, if_none_match: str | None) -> Response:
    """200 with the JSON, or 304 where the client has it."""
    headers = {"ETag": answer.etag.decode(), "Cache-Control": "no-store"}
    if if_none_match is not None and answer.matches(if_none_match.encode()):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    body = answer.body(request.app.state.stations.clock.now_us())
    return Response(body, headers=headers, media_type="application/json")
