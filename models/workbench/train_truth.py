"""From a drawn training scene to its labels: poses, boxes, masks, keypoints with visibility."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.keypoints import KeypointModel, canonical_pose
from snapfit.models.pose import Array
from snapfit.models.rle import encode_mask
from snapfit.models.train_labels import HIDDEN, OUTSIDE, VISIBLE, Instance, Labels
from snapfit.models.workbench.sighting import NO_BOX, sighting
from snapfit.models.workbench.train_picture import TrainPicture
from snapfit.models.workbench.train_scene import TrainScene

# A keypoint is seen where the part is as near to the camera as it, to this, and a little more for
# the slope of the surface between a keypoint and the middle of a pixel beside it.
_TOLERANCE_M, _TOLERANCE_PX = 0.0015, 2.0


def labels_of(
    index: int,
    scene: TrainScene,
    picture: TrainPicture,
    models: Mapping[str, KeypointModel],
    measured: npt.NDArray[np.uint16],
) -> Labels:
    """What is true in an image.

    Args:
        index: of the image.
        scene: that was drawn.
        picture: of it.
        models: of the tracked parts, by name.
        measured: (H, W) depth as the camera measures it, 0 is none.
    """
    camera, view = scene.camera, scene.camera_from_world
    instances = []
    for i, (part, body) in enumerate(scene.parts):
        model = models.get(part.name)
        if model is None:
            continue
        pose = canonical_pose(view @ body.world_from_body, model.symmetry)
        seen = sighting(camera, part.mesh, pose, picture.label == i + 1, measured)
        if seen.box_inside == NO_BOX:
            continue
        points = pose.transform(model.points)
        facing = np.einsum("ij,ij->i", model.normals @ pose.rotation.T, points) < 0
        seen_at = _visibility(camera, points, facing, seen.mask, picture.depth)
        keypoints = np.column_stack([camera.project(points), seen_at])
        instances.append(
            Instance(
                part=part.name,
                class_id=part.class_id,
                camera_from_body=pose,
                box=seen.box,
                box_inside=seen.box_inside,
                box_seen=seen.box_seen,
                n_pixels=seen.n_pixels,
                n_seen=seen.n_seen,
                n_measured=seen.n_measured,
                keypoints=keypoints.astype(np.float32),
                mask_text=encode_mask(seen.mask),
            )
        )
    return Labels(index, camera, scene.state, tuple(instances))


def _visibility(
    camera: PinholeCamera,
    points: Array,
    facing: npt.NDArray[np.bool_],
    mask: npt.NDArray[np.bool_],
    depth: npt.NDArray[np.float32],
) -> npt.NDArray[np.int64]:
    """(K,) 2, 1 or 0 for points (K, 3), camera frame, of the part that a mask (H, W) shows.

    A point is seen that faces the camera, where the part is seen, no nearer than it.
    """
    found = np.empty(len(points), dtype=np.int64)
    pixels = np.rint(camera.project(points)).astype(int)
    for i, (column, row) in enumerate(pixels):
        if not (0 <= column < camera.width and 0 <= row < camera.height):
            found[i] = OUTSIDE
            continue
        around = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
        z = points[i, 2]
        near = mask[around] & (depth[around] > z - _TOLERANCE_M - _TOLERANCE_PX * z / camera.fx)
        found[i] = VISIBLE if facing[i] and near.any() else HIDDEN
    return found
