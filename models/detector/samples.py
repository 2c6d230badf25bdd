"""Training samples: views of images and what is true in them, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from snapfit.models.detector.shapes import PartShape
from snapfit.models.detector.views import (
    View,
    ViewParameters,
    centered_view,
    relit,
    sampled_view,
)
from snapfit.models.keypoints import canonical_pose
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import Symmetry
from snapfit.models.train_labels import Instance, Labels
from snapfit.models.train_reader import TrainSample
from snapfit.models.ultralytics_layout import LEAST_PIXELS, LEAST_VISIBILITY

# Of a part that the view cuts off, so much of its box must be inside.
_LEAST_INSIDE = 0.3


@dataclass(frozen=True, eq=False)
class Sample:
    """One view, or several beside each other.

    Attributes:
        picture: (H, W, 3) uint8, blue first.
        classes: (N,) int64.
        boxes: (N, 4) float32 left, top, right, bottom, px.
        keypoints: (N, K, 3) float32 x, y (px) and 1 where inside, else 0.
        is_ignored: (N,) seen too little to be asked for.
    """

    picture: npt.NDArray[np.uint8]
    classes: npt.NDArray[np.int64]
    boxes: npt.NDArray[np.float32]
    keypoints: npt.NDArray[np.float32]
    is_ignored: npt.NDArray[np.bool_]


def training_sample(
    samples: Sequence[TrainSample],
    shapes: Mapping[str, PartShape],
    parameters: ViewParameters,
    rng: np.random.Generator,
) -> Sample:
    """A view of the first image, or tiles with views of parts in all of them.

    Args:
        samples: images; in tiles each shows as many of its parts as there are tiles for it.
        shapes: of the parts.
        parameters: of the views.
        rng: where chance comes from.

    Raises:
        DatasetError: an image cannot be read.
    """
    rows, columns = parameters.tiles
    if rng.random() >= parameters.tiled_share or rows * columns == 1:
        return _views(samples[0], shapes, parameters, 1, rng)[0]
    tile = replace(
        parameters,
        height_px=parameters.height_px // rows,
        width_px=parameters.width_px // columns,
        aimed_share=1.0,
    )
    tiles: list[Sample] = []
    for i, sample in enumerate(samples):
        wanted = (i + 1) * rows * columns // len(samples) - len(tiles)
        tiles += _views(sample, shapes, tile, wanted, rng)
    return _beside(tiles, rows, columns)


def whole_sample(
    sample: TrainSample, shapes: Mapping[str, PartShape], parameters: ViewParameters
) -> Sample:
    """The image as it is.

    Raises:
        DatasetError: it cannot be read.
    """
    labels = sample.labels
    view = centered_view((labels.camera.width, labels.camera.height), parameters)
    return _labelled(view.picture(sample.image()), view, labels, shapes)


def _views(
    sample: TrainSample,
    shapes: Mapping[str, PartShape],
    parameters: ViewParameters,
    count: int,
    rng: np.random.Generator,
) -> list[Sample]:
    """Views of one image, of another part each as far as there are any."""
    labels = sample.labels
    boxes = np.array([_box(each) for each in labels.instances if _is_seen(each)], dtype=np.float64)
    boxes = rng.permutation(boxes.reshape(-1, 4))
    image = sample.image() if count else np.zeros((1, 1, 3), dtype=np.uint8)
    found = []
    for i in range(count):
        aim = boxes[i % len(boxes)] if len(boxes) else None
        size = labels.camera.width, labels.camera.height
        view = sampled_view(size, aim, parameters, rng)
        found.append(_labelled(relit(view.picture(image), parameters, rng), view, labels, shapes))
    return found


def _beside(tiles: Sequence[Sample], rows: int, columns: int) -> Sample:
    """Tiles in rows and columns as one."""
    height, width = tiles[0].picture.shape[:2]
    shifts = [(width * (i % columns), height * (i // columns)) for i in range(len(tiles))]

    pictures = [each.picture for each in tiles]
    lines = [np.concatenate(pictures[r * columns : (r + 1) * columns], 1) for r in range(rows)]
    boxes = [each.boxes + np.array([*at, *at], np.float32) for each, at in _with(tiles, shifts)]
    keypoints = [
        each.keypoints + np.array([*at, 0], np.float32) for each, at in _with(tiles, shifts)
    ]
    return Sample(
        picture=np.concatenate(lines, 0),
        classes=np.concatenate([each.classes for each in tiles]),
        boxes=np.concatenate(boxes),
        keypoints=np.concatenate(keypoints),
        is_ignored=np.concatenate([each.is_ignored for each in tiles]),
    )


def _with(
    tiles: Sequence[Sample], shifts: Sequence[tuple[int, int]]
) -> list[tuple[Sample, tuple[int, int]]]:
    return list(zip(tiles, shifts, strict=True))


def _labelled(
    picture: npt.NDArray[np.uint8], view: View, labels: Labels, shapes: Mapping[str, PartShape]
) -> Sample:
    found = []
    for each in labels.instances:
        shape = shapes[each.part]
        pose = _pose_in(view, each.camera_from_body, shape.symmetry)
        outline = view.places(labels.camera.project(pose.transform(shape.hull_m)))
        keypoints = view.places(labels.camera.project(pose.transform(shape.keypoints_m)))
        whole = np.concatenate([outline.min(axis=0), outline.max(axis=0)])
        box = np.clip(whole, 0, (view.width, view.height, view.width, view.height))
        inside = np.prod(box[2:] - box[:2]) / max(float(np.prod(whole[2:] - whole[:2])), 1e-9)
        if inside > 0:
            ignored = not _is_seen(each) or inside < _LEAST_INSIDE
            found.append((shape.number, box, _with_presence(keypoints, view), ignored))
    n_keypoints = max((len(shape.keypoints_m) for shape in shapes.values()), default=0)
    return Sample(
        picture=picture,
        classes=np.array([each[0] for each in found], dtype=np.int64),
        boxes=np.array([each[1] for each in found], dtype=np.float32).reshape(-1, 4),
        keypoints=np.array([each[2] for each in found], np.float32).reshape(-1, n_keypoints, 3),
        is_ignored=np.array([each[3] for each in found], dtype=np.bool_),
    )


def _pose_in(view: View, camera_from_body: Pose, symmetry: Symmetry) -> Pose:
    """In the frame of the camera as it was: the pose that is canonical in the rolled camera."""
    if symmetry.is_none or view.roll_rad == 0:
        return camera_from_body
    rolled = canonical_pose(view.unrolled.inverse() @ camera_from_body, symmetry)
    return view.unrolled @ rolled


def _with_presence(places: Array, view: View) -> Array:
    inside = ((places >= 0) & (places <= (view.width, view.height))).all(axis=1)
    return np.column_stack([places, inside])


def _is_seen(each: Instance) -> bool:
    return each.visibility >= LEAST_VISIBILITY and each.n_seen >= LEAST_PIXELS


def _box(each: Instance) -> tuple[int, int, int, int]:
    x, y, width, height = each.box_inside
    return x, y, x + max(width, 1), y + max(height, 1)
