"""The assembly: its state, and the steps that lead through it."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import IfNoneMatch, OneStation
from snapfit.server.routes.pose_query import LARGEST_INTEGER, LONGEST_WAIT_S, WantedView
from snapfit.server.routes.reply import reply
from snapfit.server.schemas_assembly import AssemblyStatus, StepAnswer, StepList
from snapfit.server.watch import by_revision

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


class AssemblyQuery(BaseModel):
    """After which change the assembly is wanted."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    after_revision: Annotated[int, Field(ge=0, le=LARGEST_INTEGER)] | None = Field(
        default=None,
        description="Wait for a change of the assembly after this one of `boot_id`, or until "
        "`stale` changes: 204 if there is none within `timeout_s`.",
    )
    boot_id: str | None = Field(
        default=None,
        max_length=64,
        description="Of what `after_revision` counts from. Without it, any other revision is "
        "waited for.",
    )
    timeout_s: float = Field(
        default=20.0, ge=0, le=LONGEST_WAIT_S, description="How long to wait, seconds."
    )


async def _assembly_query(query: Annotated[AssemblyQuery, Query()]) -> AssemblyQuery:
    return query


WantedAssembly = Annotated[AssemblyQuery, Depends(_assembly_query)]


@router.get("/assembly", response_model=AssemblyStatus, responses=_RESPONSES)
async def get_assembly(
    request: Request, station: OneStation, query: WantedAssembly, if_none_match: IfNoneMatch = None
) -> Response:
    """The assembly state, its confidence, finished and next steps, and what sits wrong."""
    is_new = True
    if query.after_revision is not None:
        is_new = await station.watch.newer_than(
            query.boot_id, query.after_revision, query.timeout_s, by_revision
        )
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
