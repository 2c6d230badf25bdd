"""The assembly: its state, and the steps that lead through it."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response

from snapfit.server.problems import problem_responses
from snapfit.server.routes.assembly_query import WantedAssembly
from snapfit.server.routes.dependencies import IfNoneMatch, OneStation
from snapfit.server.routes.pose_query import WantedView
from snapfit.server.routes.reply import reply
from snapfit.server.schemas_assembly import AssemblyStatus, StepAnswer, StepList

router = APIRouter(tags=["assembly"])

_PROBLEMS = problem_responses(
    HTTPStatus.NOT_FOUND,
    HTTPStatus.CONFLICT,
    HTTPStatus.UNPROCESSABLE_ENTITY,
    HTTPStatus.SERVICE_UNAVAILABLE,
)
_RESPONSES: dict[int | str, dict[str, Any]] = {
    HTTPStatus.NO_CONTENT.value: {
        "description": "No change after `after_revision` within `timeout_s`: ask again."
    },
    HTTPStatus.NOT_MODIFIED.value: {"description": "Nothing changed since If-None-Match."},
    **_PROBLEMS,
}
StepName = Annotated[str, Path(description="The step's name in its asset.")]


@router.get("/assembly", response_model=AssemblyStatus, responses=_RESPONSES)
async def get_assembly(
    request: Request, station: OneStation, query: WantedAssembly, if_none_match: IfNoneMatch = None
) -> Response:
    """The assembly state, its confidence, finished and next steps, and what sits wrong."""
    is_new = await query.is_new(station)
    answer = station.assembly()
    now_us = request.app.state.stations.clock.now_us()
    return reply(answer, now_us, if_none_match, is_new=is_new or answer.is_stale)


@router.get("/steps", responses=_PROBLEMS)
async def get_steps(station: OneStation, query: WantedView) -> StepList:
    """All steps of the asset under assembly, and where each stands."""
    return station.steps(query.view(station)).all()


@router.get("/steps/current", responses=_PROBLEMS)
async def get_current_step(station: OneStation, query: WantedView) -> StepAnswer:
    """The step that can be taken now, or the first of several."""
    return station.steps(query.view(station)).current()


@router.get("/steps/{step}", responses=_PROBLEMS)
async def get_step(station: OneStation, step: StepName, query: WantedView) -> StepAnswer:
    """One step."""
    return station.steps(query.view(station)).named(step)
