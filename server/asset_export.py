"""What the API serves of an asset, written by the worker, which has its meshes: the API loads none.

A folder in the cache, named by what it is made from: `asset.json` (an `AssetInfo` in OpenCV's
axes), `parts/NAME.glb`, and the manifest's own media. It is written once and never changed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

from snapfit.models.asset import Asset, Part
from snapfit.models.cache import cache_directory
from snapfit.models.gltf import glb
from snapfit.models.manifest import Link, State, Step
from snapfit.models.pose import Pose
from snapfit.server.asset_paths import INFO_NAME, media_file, media_path, part_file, part_path
from snapfit.server.conventions import Convention
from snapfit.server.schemas_assembly import (
    AnnotationInfo,
    AssetInfo,
    Ghost,
    LinkInfo,
    PartInfo,
    PlacedPose,
    StateInfo,
    StepInfo,
)

# Counted up when the same asset gives other files than before.
_LAYOUT = "snapfit asset export 2"


def export_asset(asset: Asset) -> Path:
    """The folder of an asset; made if it is not there yet.

    Raises:
        OSError: the cache cannot be written.
    """
    media = {name: (asset.directory / name).read_bytes() for name in _local_media(asset)}
    folder = cache_directory() / "assets" / f"{asset.name}-{_digest(asset, media)}"
    if (folder / INFO_NAME).is_file():
        return folder
    meshes = _meshes(asset)
    text = _info(asset, meshes).model_dump_json(indent=1).encode()
    folder.parent.mkdir(parents=True, exist_ok=True)
    # Made beside and renamed, so that nobody sees half of it.
    beside = Path(tempfile.mkdtemp(prefix=".making-", dir=folder.parent))
    try:
        _write(beside / INFO_NAME, text)
        for name, content in meshes.items():
            _write(part_file(beside, name), content)
        for name, content in media.items():
            _write(media_file(beside, name), content)
        os.rename(beside, folder)  # noqa: PTH104 - Path.rename would say nothing else
    except OSError:
        shutil.rmtree(beside, ignore_errors=True)
        if not (folder / INFO_NAME).is_file():  # another worker was first
            raise
    return folder


def asset_info(asset: Asset) -> AssetInfo:
    """What the API says of an asset, in OpenCV's axes."""
    return _info(asset, _meshes(asset))


def _meshes(asset: Asset) -> dict[str, bytes]:
    return {part.name: glb(part.name, part.mesh, part.color_rgb) for part in asset.parts}


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _digest(asset: Asset, media: dict[str, bytes]) -> str:
    """Of what the files are made from: a start that finds them need not make them to know it."""
    digest = hashlib.sha256(repr((_LAYOUT, asset.name, asset.title, asset.licence)).encode())
    for part in asset.parts:
        facts = part.name, part.class_id, part.tracked, part.color_rgb, _is_symmetric(part)
        digest.update(repr((*facts, part.mesh.digest)).encode())
    for described in (*asset.states, *asset.steps):
        digest.update(described.model_dump_json().encode())
    for name, content in media.items():
        digest.update(repr((name, hashlib.sha256(content).hexdigest())).encode())
    return digest.hexdigest()[:16]


def _info(asset: Asset, meshes: dict[str, bytes]) -> AssetInfo:
    return AssetInfo(
        asset=asset.name,
        title=asset.title,
        licence=asset.licence,
        convention=Convention.OPENCV,
        parts=[_part(asset.name, part, meshes[part.name]) for part in asset.parts],
        states=[_state(state) for state in asset.states],
        steps=[_step(asset, step) for step in asset.steps],
    )


def _part(asset: str, part: Part, mesh: bytes) -> PartInfo:
    return PartInfo(
        part=part.name,
        class_id=part.class_id,
        tracked=part.tracked,
        color_rgb=list(part.color_rgb),
        symmetric=_is_symmetric(part),
        diameter_m=round(part.mesh.diameter_m, 6),
        mesh=part_path(asset, part.name),
        mesh_bytes=len(mesh),
        mesh_sha256=hashlib.sha256(mesh).hexdigest(),
    )


def _is_symmetric(part: Part) -> bool:
    return bool(part.symmetry.motions) or part.symmetry.axis is not None


def _state(state: State) -> StateInfo:
    return StateInfo(
        state=state.name, title=state.title, links=[_link(link) for link in state.links]
    )


def _link(link: Link) -> LinkInfo:
    return LinkInfo(
        parent=link.parent,
        child=link.child,
        joint=str(link.joint.type),
        **_placed(link.parent_from_child).model_dump(),
    )


def _step(asset: Asset, step: Step) -> StepInfo:
    ghost = step.ghost
    placed = None
    if ghost is not None:
        pose = _placed(ghost.parent_from_part).model_dump()
        placed = Ghost(part=ghost.part, parent=ghost.parent, **pose)
    return StepInfo(
        step=step.name,
        title=step.title,
        text=step.text,
        from_state=step.from_state,
        to_state=step.to_state,
        parts=list(step.parts),
        ghost=placed,
        annotations=[
            AnnotationInfo(part=each.part, anchor=list(each.anchor_m), text=each.text)
            for each in step.annotation
        ],
        media=[_media(asset.name, address) for address in step.media],
        expected_duration_s=step.expected_duration_s,
    )


def _placed(pose: Pose) -> PlacedPose:
    return PlacedPose(position=pose.translation.tolist(), orientation=pose.quaternion.tolist())


def _local_media(asset: Asset) -> list[str]:
    """Names of files in the bundle."""
    named = (address for step in asset.steps for address in step.media)
    return list(dict.fromkeys(name for name in named if not _is_address(name)))


def _media(asset: str, address: str) -> str:
    return address if _is_address(address) else media_path(asset, address)


def _is_address(media: str) -> bool:
    return "://" in media
