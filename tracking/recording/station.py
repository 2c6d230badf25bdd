"""From a source to what a recording tells of it before the first frame, and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from io import BytesIO
from zipfile import BadZipFile

import numpy as np

from snapfit.models.asset import BUNDLED, Asset, Part
from snapfit.models.mesh import Mesh
from snapfit.models.symmetry import Symmetry, SymmetryAxis
from snapfit.tracking.recording.build import build_here
from snapfit.tracking.recording.records import (
    ColorFormat,
    LensRecord,
    PartRecord,
    StationRecord,
    matrix_of,
    pose_of,
)
from snapfit.tracking.sources.base import Source


def station_record(
    source: Source,
    *,
    station: str,
    method: str | None,
    detector: str | None,
    finds: Sequence[str],
    color_format: ColorFormat,
) -> StationRecord:
    """What is known of a station before its first frame.

    Args:
        source: that is open.
        station: its name.
        method, detector: that track and find; None without.
        finds: the names that the detector's finder knows.
        color_format: that colour is written in.
    """
    camera = source.camera
    depth = None if camera.depth is None else LensRecord(**asdict(camera.depth))
    return StationRecord(
        station=station,
        source=source.name,
        asset=None if source.asset is None else _asset_name(source.asset),
        parts=[_part_record(part) for part in source.parts],
        method=method,
        detector=detector,
        finds=list(finds),
        frame_rate_hz=source.frame_rate_hz,
        color=LensRecord(**asdict(camera.color)),
        depth=depth,
        depth_scale_m=camera.depth_scale_m,
        color_from_depth=matrix_of(camera.color_from_depth),
        initial_poses={name: matrix_of(pose) for name, pose in source.initial_poses.items()},
        color_format=color_format,
        build=build_here(),
    )


def loose_meshes(source: Source) -> dict[str, bytes]:
    """Meshes of parts that no asset brings, by part, as `loose_part` reads them."""
    if source.asset is not None:
        return {}
    return {part.name: _packed(part.mesh) for part in source.parts}


def loose_part(record: PartRecord, attachments: Mapping[str, bytes]) -> Part:
    """A part that no asset brings.

    Raises:
        ValueError: its mesh is missing or damaged.
    """
    data = attachments.get(f"{record.name}.npz")
    if data is None:
        raise ValueError("its mesh is missing")
    try:
        with np.load(BytesIO(data), allow_pickle=False) as arrays:
            mesh = Mesh(arrays["vertices"], arrays["faces"])
    except (BadZipFile, KeyError, OSError) as error:
        raise ValueError(f"its mesh is damaged: {error}") from error
    axis = None
    if record.axis is not None:
        axis = SymmetryAxis(np.array(record.axis[0]), np.array(record.axis[1]))
    symmetry = Symmetry(tuple(pose_of(each) for each in record.motions), axis)
    return Part(record.name, mesh, record.color_rgb, record.class_id, symmetry)


def _asset_name(asset: Asset) -> str:
    """By which it is found again."""
    folder = asset.directory.resolve()
    return folder.name if folder.parent == BUNDLED.resolve() else str(folder)


def _part_record(part: Part) -> PartRecord:
    axis = part.symmetry.axis
    return PartRecord(
        name=part.name,
        mesh=part.mesh.digest,
        color_rgb=part.color_rgb,
        class_id=part.class_id,
        motions=[matrix_of(motion) for motion in part.symmetry.motions],
        axis=None if axis is None else (axis.direction.tolist(), axis.point_m.tolist()),
    )


def _packed(mesh: Mesh) -> bytes:
    file = BytesIO()
    np.savez(file, vertices=mesh.vertices, faces=mesh.faces)
    return file.getvalue()
