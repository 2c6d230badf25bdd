"""The recorded-sequence format: a folder with `sequence.json`, `color/`, `depth/`, `gt.jsonl`.

`docs/sequence-format.md` describes it for people. `SequenceWriter` writes what this reads.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from snapfit.models.asset import PALETTE_RGB, Asset, Part, find_asset, symmetry_of
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import ManifestError, SequenceError
from snapfit.models.manifest import PoseField, SymmetryTable
from snapfit.models.mesh import load_mesh
from snapfit.models.pose import Pose
from snapfit.models.recording import FrameFiles, Recording
from snapfit.models.truth import TRUTH_NAME, read_truth
from snapfit.models.validation import describe, dotted, field_keys

SEQUENCE_NAME = "sequence.json"
COLOR_FOLDERS = ("color", "rgb")
COLOR_SUFFIXES = (".png", ".jpg", ".jpeg")
# The second is BOP's name, so that one folder can be both.
COLOR_FOLDERS = ("color", "rgb")

_REMARK_PREFIX, _REMARK_SUFFIX = "reference_", "note"


class _Record(BaseModel):
    """Frozen, no NaN or infinity; unknown keys are refused, save remarks for people."""

    model_config = ConfigDict(
        extra="allow", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            for key in data.keys() - cls.model_fields.keys():
                if not key.endswith(_REMARK_SUFFIX) and not key.startswith(_REMARK_PREFIX):
                    known = ", ".join(cls.model_fields)
                    raise ValueError(f"unknown key {key!r}; known here: {known}, and remarks *note")
        return data


class CameraRecord(_Record):
    """Intrinsics of an undistorted camera."""

    width: int = Field(gt=0, le=16384, description="Image width, px.")
    height: int = Field(gt=0, le=16384, description="Image height, px.")
    fx: float = Field(gt=0, description="Focal length along x, px.")
    fy: float = Field(gt=0, description="Focal length along y, px.")
    cx: float = Field(description="Principal point x, px; pixel centres at integers.")
    cy: float = Field(description="Principal point y, px.")

    @property
    def camera(self) -> PinholeCamera:
        """The camera that these numbers describe."""
        return PinholeCamera(self.width, self.height, self.fx, self.fy, self.cx, self.cy)

    @classmethod
    def of(cls, camera: PinholeCamera, **more: Any) -> Self:
        """The record of a camera."""
        size = {"width": camera.width, "height": camera.height}
        return cls(**size, fx=camera.fx, fy=camera.fy, cx=camera.cx, cy=camera.cy, **more)


class DepthRecord(CameraRecord):
    """Intrinsics and place of the depth camera."""

    depth_scale: float = Field(gt=0, le=1, description="Metres of one unit of the depth images.")
    depth2color: PoseField = Field(
        default_factory=Pose.identity, description="`color_from_depth`, 4x4 by rows, metres."
    )


class BodyRecord(_Record):
    """A part that the sequence brings itself."""

    mesh: str = Field(min_length=1, description="Mesh file, relative to the sequence.")
    mesh_unit_m: float = Field(
        default=1.0, gt=0, le=1, description="Metres of one unit of the mesh."
    )
    geometry2body: PoseField = Field(
        default_factory=Pose.identity, description="`body_from_mesh`, 4x4 by rows, metres."
    )
    symmetry: SymmetryTable = Field(default=SymmetryTable(), description="As in a manifest.")
    initial_pose: PoseField | None = Field(
        default=None, description="`camera_from_body`, first frame."
    )


class SequenceRecord(_Record):
    """A whole `sequence.json`."""

    color: CameraRecord = Field(description="Colour camera.")
    depth: DepthRecord | None = Field(
        default=None, description="Depth camera; absent for colour alone."
    )
    frames: tuple[str, ...] = Field(min_length=1, description="Names of the frames, in order.")
    fps: float = Field(default=30.0, gt=0, le=1000, description="Frames a second.")
    bodies: dict[str, BodyRecord] = Field(
        default_factory=dict, description="Parts that the sequence brings itself."
    )
    asset: str | None = Field(
        default=None, description="A bundled asset, or a folder beside this file."
    )
    initial_poses: dict[str, PoseField] = Field(
        default_factory=dict, description="`camera_from_body` by part, first frame."
    )

    @model_validator(mode="after")
    def _names_are_plain(self) -> SequenceRecord:
        for name in self.frames:
            if not name or Path(name).name != name:
                raise ValueError(f"the frame {name!r} is no plain file name")
        if len(set(self.frames)) < len(self.frames):
            raise ValueError("a frame is named twice")
        if bool(self.bodies) == (self.asset is not None):
            raise ValueError("give either `bodies` with their meshes, or an `asset`")
        return self


def load_sequence(directory: Path, asset: Asset | None = None) -> Recording:
    """Reads a recorded sequence; decodes no image.

    Args:
        directory: folder that holds `sequence.json`.
        asset: takes the place of the bodies or the asset that the sequence names.

    Raises:
        SequenceError: a file or key is missing or wrong, or a pose is no rigid motion.
        ManifestError: the asset that the sequence names is refused.
        MeshError: a mesh is refused.
    """
    directory = Path(directory)
    path = directory / SEQUENCE_NAME
    record = read_record(path)
    if asset is None and record.asset is not None:
        asset = _find_asset(path, record.asset)
    parts = asset.tracked_parts if asset else _own_parts(directory, record)
    initial_poses = _initial_poses(path, record, parts)
    return Recording(
        name=directory.resolve().name,
        directory=directory,
        camera=_camera(record),
        frame_rate_hz=record.fps,
        frames=tuple(_files(directory, name, record.depth is not None) for name in record.frames),
        parts=parts,
        initial_poses=initial_poses,
        asset=asset,
        truth={truth.frame: truth for truth in read_truth(directory / TRUTH_NAME)},
    )


def read_record(path: Path) -> SequenceRecord:
    """Reads and checks one `sequence.json`.

    Raises:
        SequenceError: as `load_sequence`.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise SequenceError(path, "no such file: is this a recorded sequence?") from error
    except OSError as error:
        raise SequenceError(path, f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise SequenceError(path, f"is not valid JSON: {error}") from error
    try:
        return SequenceRecord.model_validate(content)
    except ValidationError as error:
        known = field_keys(SequenceRecord, CameraRecord, DepthRecord, BodyRecord, SymmetryTable)
        key, problem = describe(error, known)
        raise SequenceError(path, f"{key}: {problem}" if key else problem) from error


def _camera(record: SequenceRecord) -> RgbdCamera:
    if record.depth is None:
        return RgbdCamera(record.color.camera)
    return RgbdCamera(
        color=record.color.camera,
        depth=record.depth.camera,
        depth_scale_m=record.depth.depth_scale,
        color_from_depth=record.depth.depth2color,
    )


def _find_asset(path: Path, name: str) -> Asset:
    beside = path.parent / name
    try:
        return find_asset(beside if beside.is_dir() else name)
    except ManifestError as error:
        if error.path != Path(name):
            raise
        raise SequenceError(path, f"asset: {error.problem} (this names {name!r})") from error


def _own_parts(directory: Path, record: SequenceRecord) -> tuple[Part, ...]:
    parts = []
    for i, (name, body) in enumerate(record.bodies.items()):
        mesh = load_mesh(
            directory / body.mesh,
            unit_m=body.mesh_unit_m,
            body_from_mesh=body.geometry2body,
            require_closed=False,
        )
        color_rgb = PALETTE_RGB[i % len(PALETTE_RGB)]
        parts.append(Part(name, mesh, color_rgb, class_id=i, symmetry=symmetry_of(body.symmetry)))
    return tuple(parts)


def _initial_poses(path: Path, record: SequenceRecord, parts: tuple[Part, ...]) -> dict[str, Pose]:
    """Poses of the first frame, from the bodies and the table; the table must name known parts."""
    known = [part.name for part in parts]
    for name in record.initial_poses:
        if name not in known:
            there = ", ".join(known)
            key = dotted(("initial_poses", name))
            raise SequenceError(path, f"{key}: there is no such part; there are: {there}")
    own = {
        name: body.initial_pose
        for name, body in record.bodies.items()
        if body.initial_pose is not None and name in known
    }
    return own | record.initial_poses


def _files(directory: Path, name: str, has_depth: bool) -> FrameFiles:
    """The files of a frame; one that is missing is reported when the frame is read."""
    folder = next((each for each in COLOR_FOLDERS if (directory / each).is_dir()), "color")
    stem = directory / folder / name
    candidates = [stem.with_name(name + suffix) for suffix in COLOR_SUFFIXES]
    color = next((path for path in candidates if path.is_file()), candidates[0])
    return FrameFiles(name, color, directory / "depth" / f"{name}.png" if has_depth else None)
