"""Training images in the layout of Ultralytics' pose task, for those who want to train there.

`data.yaml`, `images/{train,val}/000123.jpg`, `labels/{train,val}/000123.txt` with a line an
instance: class, box centre and size, then u, v and visibility of each keypoint, all as shares of
the image (https://docs.ultralytics.com/datasets/pose/). Images are hard links to those of the BOP
scenes: they take no room of their own.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from snapfit.models.bop_writer import make_folder, write_bytes, write_text
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import KeypointModel
from snapfit.models.train_labels import OUTSIDE, Instance, Labels, image_folder, image_name

FOLDER = "ultralytics"
# What is seen of a part must be this much of it, and so many pixels, to be learnt.
LEAST_VISIBILITY, LEAST_PIXELS = 0.1, 40


def write_ultralytics(
    asset_folder: Path,
    train_folder: Path,
    ordered: Sequence[Labels],
    models: Sequence[KeypointModel],
) -> None:
    """Writes or completes the layout beside the BOP scenes.

    Args:
        asset_folder: where it is put, in a folder of its own.
        train_folder: of the BOP scenes.
        ordered: labels of all images.
        models: tracked parts in the order of their class numbers here, from 0.

    Raises:
        DatasetError: an image is missing, the disk is full, or the folder cannot be written.
    """
    folder = asset_folder / FOLDER
    for kind in ("images", "labels"):
        for split in ("train", "val"):
            make_folder(folder / kind / split)
    classes = {model.name: i for i, model in enumerate(models)}
    for labels in ordered:
        split, name = "val" if labels.is_validation else "train", f"{labels.index:06d}"
        source = train_folder / image_folder(labels.index) / "rgb"
        _link(source / f"{image_name(labels.index)}.jpg", folder / "images" / split / f"{name}.jpg")
        path = folder / "labels" / split / f"{name}.txt"
        if not path.is_file():
            write_text(path, label_lines(labels, classes))
    write_text(folder / "data.yaml", _data_yaml(models))


def label_lines(labels: Labels, classes: dict[str, int]) -> str:
    """The text of one image's label file; `classes` gives the number of each part."""
    return "".join(
        _line(each, labels, classes[each.part])
        for each in labels.instances
        if each.visibility >= LEAST_VISIBILITY and each.n_seen >= LEAST_PIXELS
    )


def _line(each: Instance, labels: Labels, number: int) -> str:
    width, height = labels.camera.width, labels.camera.height
    x, y, across, down = each.box_inside
    numbers = [(x + across / 2) / width, (y + down / 2) / height, across / width, down / height]
    words = [str(number), *(f"{value:.6f}" for value in numbers)]
    for u, v, seen in each.keypoints:
        # Pixel centres are integers here; there, the image's left edge is 0.
        place = (0.0, 0.0) if seen == OUTSIDE else ((u + 0.5) / width, (v + 0.5) / height)
        words += [f"{min(max(value, 0.0), 1.0):.6f}" for value in place] + [str(int(seen))]
    return " ".join(words) + "\n"


def _link(source: Path, goal: Path) -> None:
    """A second name for an image; a copy where the disk knows no such thing."""
    if goal.exists():
        return
    if not source.is_file():
        raise DatasetError(source, "is missing: remove the scene's folder and render again")
    try:
        goal.hardlink_to(source)
    except OSError:
        write_bytes(goal, source.read_bytes())


def _data_yaml(models: Sequence[KeypointModel]) -> str:
    n_keypoints = len(models[0].points)
    names = "".join(f"  {i}: {json.dumps(model.name)}\n" for i, model in enumerate(models))
    # No `path`: the paths are then relative to this file's folder, wherever it is moved. And no
    # `flip_idx`: Ultralytics then mirrors no image, for a mirrored part is another part.
    return (
        "# Keypoints are those of set.json beside the BOP scenes.\n"
        "train: images/train\nval: images/val\n"
        f"kpt_shape: [{n_keypoints}, 3]\nnames:\n{names}"
    )
