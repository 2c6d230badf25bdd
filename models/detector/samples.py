"""Training samples: a view of an image and what is true in it, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.detector.views import (
    View,
    ViewParameters,
    centered_view,
    relit,
    sampled_view,
)
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import canonical_pose
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import Symmetry
from snapfit.models.train_labels import Instance, Labels
from snapfit.models.train_reader import TrainClass, TrainSample
from snapfit.models.ultralytics_layout import LEAST_PIXELS, LEAST_VISIBILITY

# Of a part that the view cuts off, so much of its box must be inside.
_LEAST_INSIDE = 0.3


@dataclass(frozen=True, eq=False)
class PartShape:
    """What has to be known of a part to label it in a turned view.

    Attributes:
        number: of its class, from 0.
        keypoints_m: (K, 3) body frame, m.
        hull_m: (N, 3) corners of its convex hull, body frame, m.
        symmetry: of the part.
    """

    number: int
    keypoints_m: Array
    hull_m: Array
    symmetry: Symmetry


@dataclass(frozen=True, eq=False)
class Sample:
    """One view.

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


def part_shapes(asset: Asset, classes: Sequence[TrainClass]) -> dict[str, PartShape]:
    """By name, the classes of a training set.

    Raises:
        DatasetError: the set has a part that the asset has not.
    """
    parts = {part.name: part for part in asset.parts}
    shapes = {}
    for number, each in enumerate(classes):
        if each.part not in parts:
            problem = f"has no part {each.part!r}, but the training set has: render it again"
            raise DatasetError(asset.directory, problem)
        part = parts[each.part]
        shapes[each.part] = PartShape(
            number, each.keypoints_m, part.mesh.hull_points, part.symmetry
        )
    return shapes


def training_sample(
    sample: TrainSample,
    shapes: Mapping[str, PartShape],
    parameters: ViewParameters,
    rng: np.random.Generator,
) -> Sample:
    """A view of an image at random.

    Raises:
        DatasetError: the image cannot be read.
    """
    labels = sample.labels
    centers = np.array(
        [_center(each) for each in labels.instances if _is_seen(each)], dtype=np.float64
    )
    size = labels.camera.width, labels.camera.height
    view = sampled_view(size, centers.reshape(-1, 2), parameters, rng)
    picture = relit(view.picture(sample.image()), parameters, rng)
    return _labelled(picture, view, labels, shapes)


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
        limit = (view.width, view.height, view.width, view.height)
        box = np.clip(whole, 0, limit)
        inside = np.prod(box[2:] - box[:2]) / max(float(np.prod(whole[2:] - whole[:2])), 1e-9)
        if inside > 0:
            ignored = not _is_seen(each) or inside < _LEAST_INSIDE
            found.append((shape.number, box, _with_presence(keypoints, view), ignored))
    n_keypoints = max((len(shape.keypoints_m) for shape in shapes.values()), default=0)
    return Sample(
        picture,
        np.array([each[0] for each in found], dtype=np.int64),
        np.array([each[1] for each in found], dtype=np.float32).reshape(-1, 4),
        np.array([each[2] for each in found], dtype=np.float32).reshape(-1, n_keypoints, 3),
        np.array([each[3] for each in found], dtype=np.bool_),
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


def _center(each: Instance) -> tuple[float, float]:
    x, y, width, height = each.box_inside
    return x + width / 2, y + height / 2
