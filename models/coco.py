"""A BOP scene's labels in COCO's words: boxes, masks as run lengths, keypoints by category."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from snapfit.models.keypoints import KeypointModel
from snapfit.models.train_labels import OUTSIDE, Instance, Labels, image_name


def coco_scene(ordered: Sequence[Labels], models: Sequence[KeypointModel]) -> dict[str, Any]:
    """The content of `scene_gt_coco.json`.

    A box is that of the outline inside the image, as in the Ultralytics layout. Masks are of what
    is seen. A keypoint outside of the image is (0, 0, 0), as COCO has it.
    """
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for labels in ordered:
        number = int(image_name(labels.index))
        size = {"width": labels.camera.width, "height": labels.camera.height}
        images.append({"id": number, "file_name": f"rgb/{number:06d}.jpg", **size})
        for each in labels.instances:
            annotations.append(_annotation(len(annotations) + 1, number, each, labels))
    return {"images": images, "annotations": annotations, "categories": _categories(models)}


def _annotation(number: int, image: int, each: Instance, labels: Labels) -> dict[str, Any]:
    keypoints = [
        [round(float(u), 2), round(float(v), 2), int(seen)] if seen != OUTSIDE else [0, 0, 0]
        for u, v, seen in each.keypoints
    ]
    return {
        "id": number,
        "image_id": image,
        "category_id": each.class_id,
        "bbox": list(each.box_inside),
        "area": each.n_seen,
        "iscrowd": 0,
        "segmentation": {
            "size": [labels.camera.height, labels.camera.width],
            "counts": each.mask_text,
        },
        "visib_fract": round(each.visibility, 6),
        "keypoints": [value for point in keypoints for value in point],
        "num_keypoints": sum(point[2] > 0 for point in keypoints),
    }


def _categories(models: Sequence[KeypointModel]) -> list[dict[str, Any]]:
    return [
        {
            "id": model.class_id,
            "name": model.name,
            "keypoints": [f"k{i}" for i in range(len(model.points))],
            "skeleton": [],
        }
        for model in models
    ]
