"""What is true in a training image: its camera, and each part that may be seen in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.models.rle import decode_mask

Box = tuple[int, int, int, int]

OUTSIDE, HIDDEN, VISIBLE = 0, 1, 2
IMAGES_A_SCENE = 1000
TRAIN, LABELS_NAME, SET_NAME = "train", "labels.jsonl", "set.json"
# One image in twenty is kept for validation, half of them with joined parts.
_BLOCK, _VALIDATION = 40, (38, 39)


@dataclass(frozen=True, eq=False)
class Instance:
    """One part in one image.

    Attributes:
        part: its name.
        class_id: as in the asset (BOP's obj_id).
        camera_from_body: true pose; of a symmetric part, the canonical one.
        box: x, y, width, height of its outline alone, beyond the border too, px.
        box_inside: the same of what of the outline is inside the image: what a detector is to say.
        box_seen: the same of what is seen of it; (-1, -1, -1, -1) if nothing is.
        n_pixels: of its outline, beyond the border too.
        n_seen: pixels of it that are seen.
        n_measured: of the outline, where depth is measured.
        keypoints: (K, 3) float32: u, v (px, pixel centres at integers) and 2 visible, 1 hidden,
            0 outside of the image; those outside have their true place too.
        mask_text: where it is seen, as `rle.encode_mask`.
    """

    part: str
    class_id: int
    camera_from_body: Pose
    box: Box
    box_inside: Box
    box_seen: Box
    n_pixels: int
    n_seen: int
    n_measured: int
    keypoints: npt.NDArray[np.float32]
    mask_text: str

    @property
    def visibility(self) -> float:
        """Share of the outline that is seen, 0 to 1."""
        return min(self.n_seen / self.n_pixels, 1.0) if self.n_pixels else 0.0

    def mask(self, camera: PinholeCamera) -> npt.NDArray[np.bool_]:
        """(H, W) where it is seen."""
        return decode_mask(self.mask_text, camera.height, camera.width)


@dataclass(frozen=True, eq=False)
class Labels:
    """All that is true in one image.

    Attributes:
        index: of the image in its set.
        camera: that took it.
        state: assembly state of the joined parts; None if all are apart.
        instances: parts whose outline reaches into the image, hidden ones too.
    """

    index: int
    camera: PinholeCamera
    state: str | None
    instances: tuple[Instance, ...]

    @property
    def is_assembled(self) -> bool:
        """Whether parts are joined in it."""
        return self.state is not None

    @property
    def is_validation(self) -> bool:
        """Whether it is kept for validation: one image in twenty."""
        return self.index % _BLOCK in _VALIDATION

    def to_json(self) -> dict[str, Any]:
        """As it stands in `labels.jsonl`."""
        camera = self.camera
        return {
            "index": self.index,
            "size": [camera.width, camera.height],
            "intrinsics": [round(v, 6) for v in (camera.fx, camera.fy, camera.cx, camera.cy)],
            "state": self.state,
            "instances": [_instance_json(each) for each in self.instances],
        }

    @staticmethod
    def from_json(record: Mapping[str, Any]) -> Labels:
        """From a line of `labels.jsonl`.

        Raises:
            KeyError, TypeError, ValueError: it is none.
            CameraError, PoseError: its numbers cannot be.
        """
        camera = PinholeCamera(*record["size"], *record["intrinsics"])
        instances = tuple(_instance(each) for each in record["instances"])
        return Labels(int(record["index"]), camera, record["state"], instances)


def image_folder(index: int) -> str:
    """The BOP scene, a folder, in which an image lies."""
    return f"{index // IMAGES_A_SCENE:06d}"


def image_name(index: int) -> str:
    """The image's name in its scene, without ending."""
    return f"{index % IMAGES_A_SCENE:06d}"


def _instance_json(each: Instance) -> dict[str, Any]:
    return {
        "part": each.part,
        "class_id": each.class_id,
        "pose": [round(float(value), 9) for value in each.camera_from_body.matrix[:3].ravel()],
        "box": list(each.box),
        "box_inside": list(each.box_inside),
        "box_seen": list(each.box_seen),
        "pixels": [each.n_pixels, each.n_seen, each.n_measured],
        "keypoints": [
            [round(float(u), 2), round(float(v), 2), int(s)] for u, v, s in each.keypoints
        ],
        "mask": each.mask_text,
    }


def _instance(record: Mapping[str, Any]) -> Instance:
    rows = np.array(record["pose"], dtype=np.float64).reshape(3, 4)
    n_pixels, n_seen, n_measured = record["pixels"]
    return Instance(
        part=record["part"],
        class_id=int(record["class_id"]),
        camera_from_body=Pose(np.vstack([rows, [0, 0, 0, 1]])),
        box=_box(record["box"]),
        box_inside=_box(record["box_inside"]),
        box_seen=_box(record["box_seen"]),
        n_pixels=int(n_pixels),
        n_seen=int(n_seen),
        n_measured=int(n_measured),
        keypoints=np.array(record["keypoints"], dtype=np.float32).reshape(-1, 3),
        mask_text=record["mask"],
    )


def _box(numbers: list[int]) -> Box:
    x, y, width, height = (int(number) for number in numbers)
    return x, y, width, height
