"""Assets: what is assembled here, its parts' meshes, its steps' media."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, Response
from fastapi.responses import FileResponse

from snapfit.server.asset_library import ExportedAsset
from snapfit.server.byte_range import leave_one_range
from snapfit.server.problems import problem_responses
from snapfit.server.routes.dependencies import AllStations, IfNoneMatch, PartName
from snapfit.server.routes.pose_query import WantedConvention
from snapfit.server.schemas_assembly import AssetEntry, AssetInfo, AssetList

router = APIRouter(prefix="/assets", tags=["assets"])

_GLB = "model/gltf-binary"
_PROBLEMS = problem_responses(HTTPStatus.NOT_FOUND, HTTPStatus.SERVICE_UNAVAILABLE)
_MESH: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "Binary glTF 2.0: one file, metres, glTF's own axes (y up).",
        "content": {_GLB: {"schema": {"type": "string", "format": "binary"}}},
    },
    HTTPStatus.NOT_MODIFIED.value: {"description": "The client has this mesh."},
    **_PROBLEMS,
}
_MEDIA: dict[int | str, dict[str, Any]] = {
    HTTPStatus.OK.value: {
        "description": "The file.",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    },
    HTTPStatus.PARTIAL_CONTENT.value: {"description": "The bytes that the header Range asks for."},
    **_PROBLEMS,
    **problem_responses(HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE),
}


async def named_asset(
    stations: AllStations, asset: Annotated[str, Path(description="The asset's name.")]
) -> ExportedAsset:
    """The asset that the path names."""
    return stations.asset(asset)


NamedAsset = Annotated[ExportedAsset, Depends(named_asset)]
MediaName = Annotated[str, Path(description="As a step's `media` tells it.")]


@router.get("")
async def get_assets(stations: AllStations) -> AssetList:
    """The assets that this server's stations assemble; empty until a worker has opened one."""
    entries = [
        AssetEntry(asset=asset.info.asset, title=asset.info.title, stations=names)
        for asset, names in stations.assets()
    ]
    return AssetList(assets=entries)


@router.get("/{asset}", responses={**_PROBLEMS, **problem_responses(HTTPStatus(422))})
async def get_asset(asset: NamedAsset, query: WantedConvention) -> AssetInfo:
    """An asset: its parts, the assembly graph, the steps."""
    return asset.info_in(query.convention)


@router.get("/{asset}/parts/{part}.glb", response_class=Response, responses=_MESH)
async def get_mesh(
    asset: NamedAsset, part: PartName, if_none_match: IfNoneMatch = None
) -> Response:
    """A part's mesh."""
    mesh, digest = asset.mesh(part)
    headers = {"ETag": f'"{digest}"', "Cache-Control": "no-cache"}
    if if_none_match is not None and (digest in if_none_match or if_none_match.strip() == "*"):
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    return Response(mesh, headers=headers, media_type=_GLB)


@router.get("/{asset}/media/{name:path}", response_class=FileResponse, responses=_MEDIA)
async def get_media(request: Request, asset: NamedAsset, name: MediaName) -> FileResponse:
    """A picture or film of a step, or a range of its bytes."""
    path = asset.media(name)
    leave_one_range(request.scope, path.stat().st_size)
    return FileResponse(path, headers={"X-Content-Type-Options": "nosniff"})
