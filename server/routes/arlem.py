"""ARLEM, IEEE 1589-2020: an asset's steps as two documents that players of it read."""

from __future__ import annotations

import re
from http import HTTPStatus
from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.arlem.activity import activity_of
from snapfit.server.arlem.addresses import ACTIVITY_NAME, WORKPLACE_NAME, Addresses
from snapfit.server.arlem.schemas import Activity, Workplace
from snapfit.server.arlem.workplace import workplace_of
from snapfit.server.errors import NoStepsError
from snapfit.server.problems import ProblemError, problem_responses
from snapfit.server.routes.assets import NamedAsset
from snapfit.server.routes.dependencies import AllStations

router = APIRouter(prefix="/assets/{asset}/arlem", tags=["assets"])

_PROBLEMS = problem_responses(
    HTTPStatus.NOT_FOUND, HTTPStatus.UNPROCESSABLE_ENTITY, HTTPStatus.SERVICE_UNAVAILABLE
)
# What a client may call this server: a host name or address, and a port.
_HOST = re.compile(r"([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\])(:[0-9]{1,5})?")


class ArlemQuery(BaseModel):
    """What the manifest leaves open."""

    model_config = ConfigDict(extra="forbid")

    station: str | None = Field(
        default=None,
        max_length=64,
        description="Whose assembly leads from step to step; the first that assembles the asset "
        "unless told.",
    )
    language: str = Field(
        default="en", pattern="^[a-z]{2}$", description="Language of the texts, ISO 639-1."
    )


async def _addresses(
    request: Request,
    asset: NamedAsset,
    stations: AllStations,
    query: Annotated[ArlemQuery, Query()],
) -> Addresses:
    """Where everything is, as this client reaches it.

    Raises:
        ProblemError: 404, the asset is not under assembly at that station.
    """
    names = next(names for each, names in stations.assets() if each == asset)
    if query.station is not None and query.station not in names:
        raise ProblemError(
            HTTPStatus.NOT_FOUND,
            "unknown-station",
            f"Station {query.station!r} does not assemble {asset.info.asset}; "
            f"{', '.join(names)} does.",
            stations=names,
        )
    told = urlencode(query.model_dump(exclude_unset=True, exclude_none=True))
    return Addresses.served(_server(request), asset.info.asset, query.station or names[0], told)


Places = Annotated[Addresses, Depends(_addresses)]


@router.get(f"/{WORKPLACE_NAME}", response_model_exclude_none=True, responses=_PROBLEMS)
async def get_workplace(asset: NamedAsset, addresses: Places, response: Response) -> Workplace:
    """ARLEM's workplace model: parts, their points of interest, how they are recognised."""
    response.headers.update(_as_file(f"{asset.info.asset}-{WORKPLACE_NAME}"))
    return workplace_of(asset.info, addresses)


@router.get(f"/{ACTIVITY_NAME}", response_model_exclude_none=True, responses=_PROBLEMS)
async def get_activity(
    asset: NamedAsset,
    addresses: Places,
    query: Annotated[ArlemQuery, Query()],
    response: Response,
) -> Activity:
    """ARLEM's activity model: the steps, and what leads from one to the next."""
    try:
        activity = activity_of(asset.info, addresses, query.language)
    except NoStepsError as error:
        detail = f"{str(error)[0].upper()}{str(error)[1:]}."
        raise ProblemError(HTTPStatus.NOT_FOUND, "no-steps", detail) from error
    response.headers.update(_as_file(f"{asset.info.asset}-{ACTIVITY_NAME}"))
    return activity


def _as_file(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-cache"}


def _server(request: Request) -> str:
    """This server as the client calls it, or, where that makes no address, as it listens."""
    host = request.headers.get("host", "")
    if not _HOST.fullmatch(host):
        name, port = request.scope["server"]
        host = f"[{name}]:{port}" if ":" in name else f"{name}:{port}"
    return f"{request.scope['scheme']}://{host}"
