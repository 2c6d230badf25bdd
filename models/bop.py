"""Scenes in BOP's format: `scene_camera.json`, `scene_gt.json`, `rgb/`, `depth/`, `models/`.

Source: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md. BOP counts
in millimetres; what comes out is in metres.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import cv2
import numpy as np
from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from snapfit.models.asset import PALETTE_RGB, Asset, Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import CameraError, PoseError, SequenceError
from snapfit.models.mesh import load_mesh
from snapfit.models.pose import Pose
from snapfit.models.recording import FrameFiles, GroundTruth, Recording
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry
from snapfit.models.validation import describe, field_keys

CAMERA_NAME = "scene_camera.json"
TRUTH_NAME = "scene_gt.json"
VISIBILITY_NAME = "scene_gt_info.json"
MODELS_INFO_NAME = "models_info.json"

_IMAGE_FOLDERS = ("rgb", "color", "gray")
_IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")
_FRAME_RATE_HZ = 30.0
_MM = 0.001
_T = TypeVar("_T")


class BopCamera(BaseModel):
    """An image's entry of `scene_camera.json`; further keys are left to others."""

    matrix: list[float] = Field(alias="cam_K", min_length=9, max_length=9)
    depth_scale: float = Field(default=1.0, gt=0)


class BopPose(BaseModel):
    """The pose of an instance in `scene_gt.json`, millimetres."""

    rotation: list[float] = Field(alias="cam_R_m2c", min_length=9, max_length=9)
    translation: list[float] = Field(alias="cam_t_m2c", min_length=3, max_length=3)


class BopTruth(BopPose):
    """An instance's entry of `scene_gt.json`."""

    obj_id: int = Field(ge=0)


class BopVisibility(BaseModel):
    """An instance's entry of `scene_gt_info.json`."""

    visib_fract: float


def load_bop_scene(
    scene: Path, asset: Asset | None = None, models: Path | None = None
) -> Recording:
    """Reads one BOP scene; decodes its first image alone, for the size.

    Args:
        scene: folder that holds `scene_camera.json`.
        asset: gives the parts; a part's class id is its BOP object id.
        models: without an asset, folder of the meshes `obj_000001.ply` (mm); None looks for
            `models` in the scene and in the two folders above it.

    Raises:
        SequenceError: a file or key is missing or wrong, or the camera changes in the scene.
        MeshError: a mesh is refused.
    """
    scene = Path(scene)
    frames = find_images(scene)
    names = {part.class_id: part.name for part in asset.tracked_parts} if asset else {}
    truth = _read_truth(scene, frames, names, asset is not None)
    parts = asset.tracked_parts if asset else _own_parts(scene, models, truth)
    first = truth.get(frames[0].name)
    return Recording(
        name=scene.resolve().name,
        directory=scene,
        camera=shared_camera(scene, frames[0]),
        frame_rate_hz=_FRAME_RATE_HZ,
        frames=frames,
        parts=parts,
        initial_poses=first.camera_from_body if first else {},
        asset=asset,
        truth=truth,
    )


def find_images(scene: Path) -> tuple[FrameFiles, ...]:
    """The images of a scene, by number, and the depth images that belong to them."""
    folder = next((scene / name for name in _IMAGE_FOLDERS if (scene / name).is_dir()), None)
    if folder is None:
        raise SequenceError(scene, f"no folder of images: one of {', '.join(_IMAGE_FOLDERS)}")
    images = sorted(path for path in folder.iterdir() if path.suffix.lower() in _IMAGE_SUFFIXES)
    images = [path for path in images if path.stem.isdecimal()]
    if not images:
        raise SequenceError(folder, "no images in here, named by number: 000000.png")
    depth = scene / "depth"
    has_depth = depth.is_dir()
    return tuple(
        FrameFiles(path.stem, path, depth / f"{path.stem}.png" if has_depth else None)
        for path in images
    )


def shared_camera(scene: Path, first: FrameFiles) -> RgbdCamera:
    """The scene's one camera; colour and depth are aligned in BOP."""
    path = scene / CAMERA_NAME
    entries = read_json(path, TypeAdapter(dict[int, BopCamera]))
    if not entries:
        raise SequenceError(path, "is empty: it needs the camera of at least one image")
    entry = next(iter(entries.values()))
    for image, other in entries.items():
        same_matrix = np.allclose(other.matrix, entry.matrix, rtol=0, atol=1e-3)
        if not same_matrix or other.depth_scale != entry.depth_scale:
            raise SequenceError(path, f"{image}: the camera changes within the scene: split it")
    image_bgr = cv2.imread(str(first.color))
    if image_bgr is None:
        raise SequenceError(first.color, "is not a readable image, so that the size is unknown")
    height, width = image_bgr.shape[:2]
    fx, _, cx, _, fy, cy = entry.matrix[:6]
    try:
        color = PinholeCamera(width, height, fx, fy, cx, cy)
    except CameraError as error:
        raise SequenceError(path, f"cam_K: {error}") from error
    depth = color if first.depth is not None else None
    return RgbdCamera(color, depth, depth_scale_m=entry.depth_scale * _MM)


def _read_truth(
    scene: Path, frames: tuple[FrameFiles, ...], names: dict[int, str], only_named: bool
) -> dict[str, GroundTruth]:
    path = scene / TRUTH_NAME
    if not path.is_file():
        return {}
    entries = read_json(path, TypeAdapter(dict[int, list[BopTruth]]))
    visibility: dict[int, list[BopVisibility]] = {}
    if (scene / VISIBILITY_NAME).is_file():
        adapter = TypeAdapter(dict[int, list[BopVisibility]])
        visibility = read_json(scene / VISIBILITY_NAME, adapter)
    truth = {}
    for frame in frames:
        image = int(frame.name)
        if image not in entries:
            continue
        poses: dict[str, Pose] = {}
        visible: dict[str, float] = {}
        n_seen: Counter[int] = Counter()
        for i, instance in enumerate(entries[image]):
            n_seen[instance.obj_id] += 1
            name = _instance_name(instance.obj_id, n_seen[instance.obj_id], names)
            if only_named and instance.obj_id not in names:
                continue
            poses[name] = instance_pose(path, image, name, instance)
            if i < len(visibility.get(image, [])):
                visible[name] = visibility[image][i].visib_fract
        truth[frame.name] = GroundTruth(frame.name, poses, visible)
    return truth


def _instance_name(obj_id: int, number: int, names: dict[int, str]) -> str:
    """The first instance is called as its object, the next ones `..._2`, `..._3`."""
    name = names.get(obj_id, f"obj_{obj_id:06d}")
    return name if number == 1 else f"{name}_{number}"


def instance_pose(path: Path, image: int, name: str, instance: BopPose) -> Pose:
    """`camera_from_body` of an instance, metres; a wrong one is an error of the file `path`."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.reshape(instance.rotation, (3, 3))
    matrix[:3, 3] = np.array(instance.translation) * _MM
    try:
        return Pose.from_matrix(matrix)
    except PoseError as error:
        raise SequenceError(path, f"image {image}: {name}: {error}") from error


def _own_parts(scene: Path, models: Path | None, truth: dict[str, GroundTruth]) -> tuple[Part, ...]:
    """A part for each instance in the truth, with the data set's own mesh and symmetry."""
    candidates = [models] if models else [each / "models" for each in (scene, *scene.parents[:2])]
    folder = next((each for each in candidates if each.is_dir()), None)
    if folder is None:
        raise SequenceError(scene, "no `models` folder: name one, or give an asset")
    symmetries = read_symmetries(folder / MODELS_INFO_NAME)
    names = sorted({name for each in truth.values() for name in each.camera_from_body})
    parts = []
    for i, name in enumerate(names):
        obj_id = int(name.split("_")[1])
        mesh = load_mesh(folder / f"obj_{obj_id:06d}.ply", unit_m=_MM, require_closed=False)
        color_rgb = PALETTE_RGB[i % len(PALETTE_RGB)]
        parts.append(Part(name, mesh, color_rgb, obj_id, symmetries.get(obj_id, NO_SYMMETRY)))
    return tuple(parts)


def read_symmetries(path: Path) -> dict[int, Symmetry]:
    """Symmetries by object id from `models_info.json`; none without the file."""
    if not path.is_file():
        return {}
    entries = read_json(path, TypeAdapter(dict[int, dict[str, Any]]))
    return {obj_id: symmetry_from_info(path, obj_id, info) for obj_id, info in entries.items()}


def symmetry_from_info(path: Path, obj_id: int | str, info: Mapping[str, Any]) -> Symmetry:
    """The symmetry of one object of `models_info.json`; a wrong one is an error of the file."""
    try:
        return Symmetry.from_bop(info)
    except (PoseError, ValueError, KeyError) as error:
        raise SequenceError(path, f"{obj_id}: symmetry: {error}") from error


def read_json(path: Path, adapter: TypeAdapter[_T]) -> _T:
    """Reads and checks one of the format's files.

    Raises:
        SequenceError: it cannot be read, is no JSON, or a key is missing or wrong.
    """
    try:
        return adapter.validate_python(json.loads(path.read_text(encoding="utf-8")))
    except ValidationError as error:
        known = field_keys(BopCamera, BopTruth, BopVisibility)
        key, problem = describe(error, known)
        raise SequenceError(path, f"{key}: {problem}") from error
    except OSError as error:
        raise SequenceError(path, f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise SequenceError(path, f"is not valid JSON: {error}") from error
