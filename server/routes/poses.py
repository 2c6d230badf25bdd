"""Poses: of all parts, of one part."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Request, Response

from snapfit.server.clock import Clock
from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import IfNoneMatch, OneStation, PartName
from snapfit.server.routes.pose_query import PoseQuery, WantedPoses, check_at_us
from snapfit.server.routes.reply import reply
from snapfit.server.schemas import PartSnapshot, PoseSnapshot
from snapfit.server.station import Station

router = APIRouter(tags=["poses"])

_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.NO_CONTENT.value: {
        "description": "No snapshot after `after_seq` within `timeout_s`: ask again."
    },
    HTTPStatus.NOT_MODIFIED.value: {"description": "Nothing changed since If-None-Match."},
    **problem_responses(
        HTTPStatus.NOT_FOUND,
        HTTPStatus.CONFLICT,
        HTTPStatus.UNPROCESSABLE_ENTITY,
        HTTPStatus.SERVICE_UNAVAILABLE,
    ),
}


@router.get("/poses", response_model=PoseSnapshot, responses=_RESPONSES)
async def get_poses(
    request: Request, station: OneStation, query: WantedPoses, if_none_match: IfNoneMatch = None
) -> Response:
    """The poses of all parts in the latest frame."""
    return await _poses(request, station, query, if_none_match)


@router.get("/poses/{part}", response_model=PartSnapshot, responses=_RESPONSES)
async def get_part_pose(
    request: Request,
    station: OneStation,
    part: PartName,
    query: WantedPoses,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """The pose of one part in the latest frame."""
    return await _poses(request, station, query, if_none_match, part)


async def _poses(
    request: Request,
    station: Station,
    query: PoseQuery,
    if_none_match: str | None,
    part: str | None = None,
) -> Response:
    """Of all parts or of one; after a wait, where a later snapshot is asked for."""
    clock: Clock = request.app.state.stations.clock
    at_us = query.at_us
    if at_us is not None:
        check_at_us(at_us, clock.now_us())
    is_new = await query.is_new(station)
    view = query.view(station)
    answer = station.poses(view, at_us) if part is None else station.part(part, view, at_us)
    return reply(answer, clock.now_us(), if_none_match, is_new=is_new or answer.is_stale)
