"""Anchors: align a client's world with the station's camera."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Path, Response

from snapfit.server.alignment import Deviation
from snapfit.server.anchors import Anchor
from snapfit.server.conventions import AXES, Convention
from snapfit.server.problems import problem_responses
from snapfit.server.rigid import Rigid
from snapfit.server.routes.dependencies import OneStation
from snapfit.server.routes.pose_query import ANCHOR_NAME, WantedConvention
from snapfit.server.schemas_anchors import AnchorInfo, AnchorList, AnchorRequest, Apart
from snapfit.server.schemas_assembly import PlacedPose
from snapfit.server.station import Station

router = APIRouter(prefix="/anchors", tags=["anchors"])

_PROBLEMS = problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.UNPROCESSABLE_ENTITY)
_PUT: dict[int | str, dict[str, Any]] = {
    HTTPStatus.CREATED.value: {"model": AnchorInfo, "description": "A new anchor."},
    **_PROBLEMS,
    **problem_responses(
        HTTPStatus.BAD_REQUEST, HTTPStatus.CONFLICT, HTTPStatus.SERVICE_UNAVAILABLE
    ),
}
_DELETE = {**_PROBLEMS, **problem_responses(HTTPStatus.SERVICE_UNAVAILABLE)}
AnchorName = Annotated[
    str, Path(description="A name that the client chooses.", pattern=f"^{ANCHOR_NAME}$")
]


@router.get("", responses=_PROBLEMS)
async def get_anchors(station: OneStation, query: WantedConvention) -> AnchorList:
    """All anchors that have not expired."""
    anchors = [_info(station, anchor, query.convention) for anchor in station.news.anchors.all()]
    return AnchorList(anchors=anchors)


@router.get("/{anchor}", responses=_PROBLEMS)
async def get_anchor(
    station: OneStation, anchor: AnchorName, query: WantedConvention
) -> AnchorInfo:
    """One anchor."""
    return _info(station, station.news.anchors.named(anchor), query.convention)


@router.put("/{anchor}", responses=_PUT)
async def put_anchor(
    response: Response, station: OneStation, anchor: AnchorName, request: AnchorRequest
) -> AnchorInfo:
    """Say where the board is in the client's world; the server averages over what is put."""
    given = request.world_from_marker
    world = Rigid(given.position, given.orientation).along(AXES[request.convention].inverse)
    it, is_new = await station.news.anchors.put(
        anchor, request.board, world, ttl_s=request.ttl_s, restart=request.restart
    )
    await station.wait_for_anchor(it)
    response.status_code = HTTPStatus.CREATED if is_new else HTTPStatus.OK
    return _info(station, it, request.convention)


@router.delete("/{anchor}", status_code=HTTPStatus.NO_CONTENT, responses=_DELETE)
async def delete_anchor(station: OneStation, anchor: AnchorName) -> None:
    """Forget an anchor."""
    await station.news.anchors.delete(anchor)


def _info(station: Station, anchor: Anchor, convention: Convention) -> AnchorInfo:
    pose, view, record = anchor.world_from_camera(), anchor.view, anchor.record
    residual = anchor.worlds.scatter() or Deviation(0.0, 0.0)
    has_seen = len(view.poses) > 0
    return AnchorInfo(
        station=station.name,
        anchor=anchor.name,
        frame=f"anchor:{anchor.name}",
        convention=convention,
        board=record.board,
        aligned=pose is not None,
        world_from_camera=None if pose is None else _placed(pose, convention),
        samples=len(anchor.worlds),
        residual=Apart(**residual._asdict()),
        camera_samples=len(view.poses),
        camera_residual=_apart(view.poses.scatter()),
        camera_error_px=view.error_px if has_seen else None,
        seen_at_us=view.seen_at_us if has_seen else None,
        drift=_apart(anchor.drift),
        drifting=anchor.is_drifting,
        updated_at_us=record.updated_at_us,
        expires_at_us=record.expires_at_us,
    )


def _placed(pose: Rigid, convention: Convention) -> PlacedPose:
    position, orientation = pose.along(AXES[convention])
    return PlacedPose(position=list(position), orientation=list(orientation))


def _apart(off: Deviation | None) -> Apart | None:
    return None if off is None else Apart(**off._asdict())
