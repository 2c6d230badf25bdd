"""Writes training images as BOP scenes of a thousand, so that a broken-off writing goes on.

A set lies in ASSET/train: scenes `000000`, `000001` and so on in BOP's format as its `train_pbr`
(millimetres), each with `labels.jsonl`, which holds all that is true, and `set.json`, which says
what the keypoints and classes are. An image is finished when its entry lies in `.frames`; at the
end the entries go into the scene's own files and are taken away.

Masks are run lengths in `scene_gt_coco.json`, because eight small PNG files an image would be
more than a hundred thousand for a set; they are written on request.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.bop import CAMERA_NAME, TRUTH_NAME, VISIBILITY_NAME
from snapfit.models.bop_writer import (
    DEPTH_PNG,
    ENTRIES,
    MASK_PNG,
    json_by_lines,
    make_folder,
    write_image,
    write_text,
)
from snapfit.models.coco import coco_scene
from snapfit.models.errors import CameraError, DatasetError, PoseError
from snapfit.models.keypoints import KeypointModel
from snapfit.models.train_labels import (
    IMAGES_A_SCENE,
    LABELS_NAME,
    SET_NAME,
    TRAIN,
    Instance,
    Labels,
    image_folder,
    image_name,
)

COCO_NAME = "scene_gt_coco.json"
_MM, _DEPTH_UNIT_MM = 1000.0, 1.0


class TrainWriter:
    """Writes the images of one asset, in any order and from several processes.

    Raises:
        DatasetError: the folder cannot be made.
    """

    def __init__(self, asset_folder: Path) -> None:
        self.folder = Path(asset_folder) / TRAIN
        make_folder(self.folder)

    def write(
        self,
        labels: Labels,
        color: npt.NDArray[np.uint8],
        quality: int,
        depth: npt.NDArray[np.uint16] | None = None,
        masks: bool = False,
    ) -> None:
        """Writes an image; it counts as finished only when all of it lies on disk.

        Args:
            labels: of the image.
            color: (H, W, 3) uint8, blue first.
            quality: of the JPEG, 1 to 100.
            depth: (H, W) uint16, mm; None writes none.
            masks: whether to write masks as PNG files too.

        Raises:
            DatasetError: the disk is full, or the folder cannot be written.
        """
        scene = self.folder / image_folder(labels.index)
        name = image_name(labels.index)
        for folder in ("rgb", ENTRIES, *(["depth"] if depth is not None else [])):
            make_folder(scene / folder)
        options = [cv2.IMWRITE_JPEG_QUALITY, quality]
        write_image(scene / "rgb" / f"{name}.jpg", color, options)
        if depth is not None:
            write_image(scene / "depth" / f"{name}.png", depth, DEPTH_PNG)
        if masks:
            make_folder(scene / "mask_visib")
            for i, each in enumerate(labels.instances):
                mask = each.mask(labels.camera).astype(np.uint8) * np.uint8(255)
                write_image(scene / "mask_visib" / f"{name}_{i:06d}.png", mask, MASK_PNG)
        write_text(scene / ENTRIES / f"{name}.json", _line(labels))

    def finished(self) -> set[int]:
        """Indices of the images that are there."""
        found = set()
        for scene in scenes_in(self.folder):
            first = _first_index(scene)
            entries = (path.stem for path in (scene / ENTRIES).glob("*.json"))
            found |= {first + int(name) for name in entries if name.isdecimal()}
            if (scene / LABELS_NAME).is_file():
                found |= {labels.index for labels in read_labels(scene / LABELS_NAME)}
        return found

    def finish(self, models: Sequence[KeypointModel], asset: str, note: str) -> list[Labels]:
        """Puts the scenes' own files together; returns the labels of all images, in order.

        Raises:
            DatasetError: an entry is damaged (it is taken away, so that its image is made anew),
                or as `write`.
        """
        write_text(self.folder / SET_NAME, json.dumps(_set_record(models, asset, note)) + "\n")
        return [labels for scene in scenes_in(self.folder) for labels in _gathered(scene, models)]


def scenes_in(folder: Path) -> list[Path]:
    """The scenes of a set, in order."""
    return sorted(path for path in folder.glob("[0-9]*") if path.is_dir() and path.name.isdecimal())


def read_labels(path: Path) -> list[Labels]:
    """All lines of a `labels.jsonl`.

    Raises:
        DatasetError: a line is damaged; says which.
    """
    found = []
    for i, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        try:
            found.append(Labels.from_json(json.loads(line)))
        except (KeyError, TypeError, ValueError, CameraError, PoseError) as error:
            problem = f"line {i} is damaged ({error}): remove the scene's folder and render again"
            raise DatasetError(path, problem) from error
    return found


def _gathered(scene: Path, models: Sequence[KeypointModel]) -> list[Labels]:
    """Moves a scene's entries into its own files; returns the labels of all its images."""
    path = scene / LABELS_NAME
    by_index = {labels.index: labels for labels in read_labels(path)} if path.is_file() else {}
    entries = sorted((scene / ENTRIES).glob("*.json"))
    for entry in entries:
        try:
            labels = Labels.from_json(json.loads(entry.read_text(encoding="utf-8")))
        except (KeyError, TypeError, ValueError) as error:
            entry.unlink()
            raise DatasetError(entry, "was damaged and is gone: run the same again") from error
        by_index[labels.index] = labels
    ordered = [by_index[index] for index in sorted(by_index)]
    # The labels go last: without them, the other files are made anew.
    if entries:
        for name, content in _bop_files(ordered).items():
            write_text(scene / name, json_by_lines(content))
        write_text(scene / COCO_NAME, json.dumps(coco_scene(ordered, models)))
        write_text(path, "".join(_line(labels) for labels in ordered))
    for entry in entries:
        entry.unlink()
    if (scene / ENTRIES).is_dir():
        (scene / ENTRIES).rmdir()
    return ordered


def _bop_files(ordered: Sequence[Labels]) -> dict[str, dict[int, Any]]:
    number = {labels.index: int(image_name(labels.index)) for labels in ordered}
    return {
        CAMERA_NAME: {number[each.index]: _camera(each) for each in ordered},
        TRUTH_NAME: {number[each.index]: [_truth(i) for i in each.instances] for each in ordered},
        VISIBILITY_NAME: {
            number[each.index]: [_info(i) for i in each.instances] for each in ordered
        },
    }


def _camera(labels: Labels) -> dict[str, Any]:
    camera = labels.camera
    matrix = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
    return {"cam_K": [round(v, 6) for v in matrix], "depth_scale": _DEPTH_UNIT_MM}


def _truth(each: Instance) -> dict[str, Any]:
    pose = each.camera_from_body
    return {
        "cam_R_m2c": [round(float(value), 9) for value in pose.rotation.ravel()],
        "cam_t_m2c": [round(float(value) * _MM, 6) for value in pose.translation],
        "obj_id": each.class_id,
    }


def _info(each: Instance) -> dict[str, Any]:
    return {
        "bbox_obj": each.box,
        "bbox_visib": each.box_seen,
        "px_count_all": each.n_pixels,
        "px_count_valid": each.n_measured,
        "px_count_visib": each.n_seen,
        "visib_fract": round(each.visibility, 6),
    }


def _set_record(models: Sequence[KeypointModel], asset: str, note: str) -> dict[str, Any]:
    return {
        "asset": asset,
        "note": note,
        "classes": [
            {
                "part": model.name,
                "class_id": model.class_id,
                "symmetry": model.symmetry.kind,
                "keypoints_m": np.round(model.points, 7).tolist(),
            }
            for model in models
        ],
    }


def _line(labels: Labels) -> str:
    return json.dumps(labels.to_json(), separators=(",", ":")) + "\n"


def _first_index(scene: Path) -> int:
    return int(scene.name) * IMAGES_A_SCENE
