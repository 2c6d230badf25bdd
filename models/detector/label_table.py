"""What is true in all training images, as tensors: views are cut and labelled many at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from snapfit.models.detector.shapes import PartShape
from snapfit.models.errors import DatasetError
from snapfit.models.train_labels import Instance
from snapfit.models.train_reader import TrainSample
from snapfit.models.ultralytics_layout import LEAST_PIXELS, LEAST_VISIBILITY

Group = tuple[Sequence[TrainSample], Mapping[str, PartShape]]
"""Images of one asset, and its parts by name; the class numbers of several assets differ."""


@dataclass(frozen=True, eq=False)
class LabelTable:
    """The parts in N images of one size, filled up to M an image.

    Attributes:
        classes: (N, M) int64; -1 where there is none.
        rotations: (N, M, 3, 3) of the true canonical pose, camera from body.
        translations: (N, M, 3) likewise, m.
        boxes: (N, M, 4) left, top, right, bottom of the outline inside the image, px.
        is_seen: (N, M) enough of it to be asked for.
        cameras: (N, 4) fx, fy, cx, cy, px.
        size: width and height of the images, px.
    """

    classes: Tensor
    rotations: Tensor
    translations: Tensor
    boxes: Tensor
    is_seen: Tensor
    cameras: Tensor
    size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.classes)

    def to(self, device: torch.device) -> LabelTable:
        """The same on another device."""
        names = [each.name for each in fields(self) if each.name != "size"]
        return replace(self, **{name: getattr(self, name).to(device) for name in names})


def label_table(groups: Sequence[Group]) -> LabelTable:
    """The labels of all images of all groups, in order.

    Raises:
        DatasetError: there are none, or they are of more than one size.
    """
    labels = [(sample.labels, shapes) for samples, shapes in groups for sample in samples]
    sizes = {(each.camera.width, each.camera.height) for each, _ in labels}
    if len(sizes) != 1:
        problem = f"training images are of one size, these are of {sorted(sizes) or 'none'}"
        raise DatasetError(Path(), problem)
    most = max(1, *(len(each.instances) for each, _ in labels))
    shape = len(labels), most
    classes = np.full(shape, -1, dtype=np.int64)
    poses = np.zeros((*shape, 4, 4), dtype=np.float32)
    poses[..., range(4), range(4)] = 1
    poses[..., 2, 3] = 1
    boxes = np.zeros((*shape, 4), dtype=np.float32)
    is_seen = np.zeros(shape, dtype=np.bool_)
    for i, (each, shapes) in enumerate(labels):
        for j, instance in enumerate(each.instances):
            classes[i, j] = shapes[instance.part].number
            poses[i, j] = instance.camera_from_body.matrix
            boxes[i, j] = box_inside(instance)
            is_seen[i, j] = is_seen_enough(instance)
    numbers = [(e.camera.fx, e.camera.fy, e.camera.cx, e.camera.cy) for e, _ in labels]
    tensors = torch.from_numpy(poses)
    return LabelTable(
        classes=torch.from_numpy(classes),
        rotations=tensors[..., :3, :3].contiguous(),
        translations=tensors[..., :3, 3].contiguous(),
        boxes=torch.from_numpy(boxes),
        is_seen=torch.from_numpy(is_seen),
        cameras=torch.tensor(numbers, dtype=torch.float32),
        size=sizes.pop(),
    )


def is_seen_enough(each: Instance) -> bool:
    """Whether so much of a part is seen that a detector has to find it."""
    return each.visibility >= LEAST_VISIBILITY and each.n_seen >= LEAST_PIXELS


def box_inside(each: Instance) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the part's outline inside the image, px; never empty."""
    x, y, width, height = each.box_inside
    return x, y, x + max(width, 1), y + max(height, 1)
