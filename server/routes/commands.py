"""What an operator can do: start anew, have parts looked for again, say which state holds."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Body

from snapfit.server.commands import CommandKind, Outcome
from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import OneStation
from snapfit.server.schemas_commands import CommandResult, ReinitialiseRequest, StateRequest
from snapfit.server.station import Station

router = APIRouter(tags=["commands"])

_RESPONSES = problem_responses(
    HTTPStatus.BAD_REQUEST,
    HTTPStatus.NOT_FOUND,
    HTTPStatus.CONFLICT,
    HTTPStatus.UNPROCESSABLE_ENTITY,
    HTTPStatus.SERVICE_UNAVAILABLE,
)


@router.post("/reset", responses=_RESPONSES)
async def reset(station: OneStation) -> CommandResult:
    """Begin anew: the first assembly state, and all parts are looked for again."""
    return _result(station, "reset", await station.commands.order(CommandKind.RESET))


@router.post("/reinitialise", responses=_RESPONSES)
async def reinitialise(
    station: OneStation, request: Annotated[ReinitialiseRequest | None, Body()] = None
) -> CommandResult:
    """Look for parts again, all or those that are named; the assembly state stays."""
    parts = [] if request is None else request.parts
    outcome = await station.commands.order(CommandKind.REINITIALISE, parts=parts)
    return _result(station, "reinitialise", outcome)


@router.put("/assembly/state", responses=_RESPONSES)
async def put_state(station: OneStation, request: StateRequest) -> CommandResult:
    """Say which assembly state holds; tracking goes on from there."""
    outcome = await station.commands.order(CommandKind.SET_STATE, state=request.state)
    return _result(station, "set_state", outcome)


def _result(station: Station, command: str, outcome: Outcome) -> CommandResult:
    return CommandResult(
        station=station.name,
        command=command,
        changed=bool(outcome.done),
        done=list(outcome.done),
        state=outcome.state,
    )
