"""Writes a scene in BOP's format, frame by frame, so that a broken-off writing can be taken up.

Source: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md. BOP counts in
millimetres. A frame is finished when its entry lies in `.frames/`; the scene's own JSON files are
put together from the entries at the end, `sequence.json` last.
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset, Part
from snapfit.models.bop import CAMERA_NAME, MODELS_INFO_NAME, TRUTH_NAME, VISIBILITY_NAME
from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import DatasetError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import SEQUENCE_NAME, CameraRecord, DepthRecord, SequenceRecord
from snapfit.models.symmetry import Symmetry
from snapfit.models.truth import TRUTH_NAME as LINES_NAME
from snapfit.models.truth import truth_line

ENTRIES = ".frames"
_JPEG = [cv2.IMWRITE_JPEG_QUALITY, 93]
# Prediction from neighbours gains nothing on noisy depth; OpenCV before 4.11 cannot leave it out.
_UNFILTERED = (
    [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE]
    if hasattr(cv2, "IMWRITE_PNG_FILTER_NONE")
    else []
)
DEPTH_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1, *_UNFILTERED]
MASK_PNG = [cv2.IMWRITE_PNG_BILEVEL, 1, cv2.IMWRITE_PNG_COMPRESSION, 1]
_FOLDERS = ("rgb", "depth", "mask_visib", ENTRIES)
_MM = 1000.0


class BopWriter:
    """Writes the frames of one scene, in any order and from several processes.

    Raises:
        DatasetError: the folder cannot be made.
    """

    def __init__(self, scene: Path, camera: RgbdCamera) -> None:
        self._scene = Path(scene)
        self._camera = camera
        for folder in _FOLDERS:
            make_folder(self._scene / folder)

    def finished(self) -> set[int]:
        """Numbers of the frames that are there already."""
        names = (path.stem for path in (self._scene / ENTRIES).glob("*.json"))
        return {int(name) for name in names if name.isdecimal()}

    def write(
        self,
        index: int,
        color: npt.NDArray[np.uint8],
        depth: npt.NDArray[np.uint16],
        masks: Sequence[npt.NDArray[np.bool_]],
        entry: Mapping[str, Any],
    ) -> None:
        """Writes a frame; it counts as finished only when all of it lies on disk.

        Args:
            index: number of the image.
            color: (H, W, 3) uint8, blue first.
            depth: (H, W) uint16, mm.
            masks: (H, W) where each instance is seen, in the order of the entry's.
            entry: `gt` and `info`, lists as in BOP, `poses` (4x4 by part), `visib`, `state`, and
                what else is to be counted at the end.

        Raises:
            DatasetError: the disk is full, or the folder cannot be written.
        """
        name = f"{index:06d}"
        write_image(self._scene / "rgb" / f"{name}.jpg", color, _JPEG)
        write_image(self._scene / "depth" / f"{name}.png", depth, DEPTH_PNG)
        for i, mask in enumerate(masks):
            picture = mask.astype(np.uint8) * np.uint8(255)
            write_image(self._scene / "mask_visib" / f"{name}_{i:06d}.png", picture, MASK_PNG)
        write_text(self._scene / ENTRIES / f"{name}.json", json.dumps(entry))

    def entries(self) -> dict[int, dict[str, Any]]:
        """The entries of all finished frames, in order.

        Raises:
            DatasetError: an entry is damaged; it is taken away, so that its frame is made anew.
        """
        found = {}
        for index in sorted(self.finished()):
            path = self._scene / ENTRIES / f"{index:06d}.json"
            try:
                found[index] = json.loads(path.read_text(encoding="utf-8"))
            except ValueError as error:
                path.unlink()
                raise DatasetError(path, "was damaged and is gone: run the same again") from error
        return found

    def finish(self, asset: Asset, frame_rate_hz: float, note: str) -> None:
        """Writes the scene's own files from the entries.

        Raises:
            DatasetError: there is no frame, or as `write`.
        """
        entries = self.entries()
        if not entries:
            raise DatasetError(self._scene, "has no finished frame")
        color = self._camera.color
        matrix = [color.fx, 0.0, color.cx, 0.0, color.fy, color.cy, 0.0, 0.0, 1.0]
        camera = {"cam_K": matrix, "depth_scale": self._camera.depth_scale_m * _MM}
        for name, content in (
            (CAMERA_NAME, dict.fromkeys(entries, camera)),
            (TRUTH_NAME, {index: entry["gt"] for index, entry in entries.items()}),
            (VISIBILITY_NAME, {index: entry["info"] for index, entry in entries.items()}),
        ):
            write_text(self._scene / name, json_by_lines(content))
        lines = [truth_line(_truth(index, entry)) for index, entry in entries.items()]
        write_text(self._scene / LINES_NAME, "\n".join(lines) + "\n")
        first = next(iter(entries.values()))["poses"]
        fields: dict[str, Any] = {
            "color": CameraRecord.of(color),
            "depth": DepthRecord.of(color, depth_scale=self._camera.depth_scale_m),
            "frames": tuple(f"{index:06d}" for index in entries),
            "fps": frame_rate_hz,
            "asset": asset.name,
            "initial_poses": first,
            "note": note,
        }
        record = SequenceRecord(**fields)
        text = record.model_dump_json(indent=1, exclude_none=True, exclude_unset=True)
        write_text(self._scene / SEQUENCE_NAME, text + "\n")


def instance(part: Part, pose: Pose) -> dict[str, Any]:
    """A part's entry of `scene_gt.json`."""
    return {
        "cam_R_m2c": [round(float(value), 9) for value in pose.rotation.ravel()],
        "cam_t_m2c": [round(float(value) * _MM, 6) for value in pose.translation],
        "obj_id": part.class_id,
    }


def write_models(folder: Path, asset: Asset) -> None:
    """Meshes `obj_000001.ply` (mm) of the tracked parts, and `models_info.json`.

    Raises:
        DatasetError: as `BopWriter.write`.
    """
    make_folder(folder)
    info = {}
    for part in asset.tracked_parts:
        low, high = part.mesh.vertices.min(axis=0) * _MM, part.mesh.vertices.max(axis=0) * _MM
        info[part.class_id] = {
            "diameter": round(part.mesh.diameter_m * _MM, 6),
            **{f"min_{axis}": round(float(low[i]), 6) for i, axis in enumerate("xyz")},
            **{f"size_{axis}": round(float((high - low)[i]), 6) for i, axis in enumerate("xyz")},
            **_symmetries(part.symmetry),
        }
        write_bytes(folder / f"obj_{part.class_id:06d}.ply", _ply(part))
    write_text(folder / MODELS_INFO_NAME, json.dumps(info, indent=1) + "\n")


def make_folder(path: Path) -> None:
    """Makes a folder and those above it.

    Raises:
        DatasetError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DatasetError(path, f"cannot be made: {error.strerror}") from error


def write_text(path: Path, text: str) -> None:
    """As `write_bytes`, in UTF-8."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Writes a file whole or not at all.

    Raises:
        DatasetError: the disk is full, or the file cannot be written.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        try:
            draft.write_bytes(content)
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            problem = "the disk is full; finished frames stay: make room and run the same again"
            raise DatasetError(path, problem) from error
        raise DatasetError(path, f"cannot be written: {error.strerror}") from error


def write_image(path: Path, image: npt.NDArray[np.generic], options: list[int]) -> None:
    """Encodes a picture as its name says, with OpenCV's options, and writes it as `write_bytes`."""
    done, data = cv2.imencode(path.suffix, image, options)
    if not done:
        raise DatasetError(path, "cannot be encoded")
    write_bytes(path, data.tobytes())


def json_by_lines(content: Mapping[int, Any]) -> str:
    """JSON with a line an image, as BOP's own files are."""
    lines = [f'  "{index}": {json.dumps(value)}' for index, value in content.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _truth(index: int, entry: Mapping[str, Any]) -> GroundTruth:
    poses = {name: Pose(np.array(rows)) for name, rows in entry["poses"].items()}
    return GroundTruth(f"{index:06d}", poses, entry["visib"], entry["state"])


def _symmetries(symmetry: Symmetry) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if symmetry.motions:
        rows = []
        for motion in symmetry.motions:
            matrix = motion.matrix.copy()
            matrix[:3, 3] *= _MM
            rows.append([round(float(value), 9) for value in matrix.ravel()])
        found["symmetries_discrete"] = rows
    if symmetry.axis is not None:
        offset = [float(value) * _MM for value in symmetry.axis.point_m]
        axis = [float(value) for value in symmetry.axis.direction]
        found["symmetries_continuous"] = [{"axis": axis, "offset": offset}]
    return found


def _ply(part: Part) -> bytes:
    """A binary PLY in millimetres."""
    vertices = (part.mesh.vertices * np.float32(_MM)).astype("<f4")
    faces = np.empty(len(part.mesh.faces), dtype=[("n", "u1"), ("index", "<i4", 3)])
    faces["n"], faces["index"] = 3, part.mesh.faces
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return header.encode() + vertices.tobytes() + faces.tobytes()
