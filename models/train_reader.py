"""Reads a set of training images as `snapfit dataset render --split train` writes it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.errors import DatasetError
from snapfit.models.pose import Array
from snapfit.models.train_labels import (
    LABELS_NAME,
    SET_NAME,
    TRAIN,
    Labels,
    image_name,
)
from snapfit.models.train_writer import read_labels, scenes_in


@dataclass(frozen=True, eq=False)
class TrainClass:
    """A part as the network's class.

    Attributes:
        part: its name.
        class_id: as in the asset.
        keypoints_m: (K, 3) body frame, m.
    """

    part: str
    class_id: int
    keypoints_m: Array


@dataclass(frozen=True, eq=False)
class TrainSample:
    """One image and what is true in it.

    Attributes:
        path: of the image.
        labels: what is true in it.
    """

    path: Path
    labels: Labels

    def image(self) -> npt.NDArray[np.uint8]:
        """(H, W, 3) uint8, blue first.

        Raises:
            DatasetError: it is missing or cannot be decoded.
        """
        image = cv2.imread(str(self.path), cv2.IMREAD_COLOR)
        if image is None:
            raise DatasetError(self.path, "is missing or no image: render its scene again")
        pixels: npt.NDArray[np.uint8] = np.asarray(image, dtype=np.uint8)
        return pixels


class TrainSet:
    """All images of an asset, in order; labels are in memory, images are read one by one.

    Attributes:
        asset: its name.
        classes: tracked parts; the place in this tuple is the network's class number.

    Raises:
        DatasetError: the folder holds no finished set, or one that is damaged.
    """

    def __init__(self, asset_folder: Path) -> None:
        folder = Path(asset_folder) / TRAIN
        path = folder / SET_NAME
        if not path.is_file():
            problem = "no finished training set: run snapfit dataset render --split train"
            raise DatasetError(path, problem)
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
            self.asset = str(record["asset"])
            self.classes = tuple(
                TrainClass(each["part"], int(each["class_id"]), np.array(each["keypoints_m"]))
                for each in record["classes"]
            )
        except (KeyError, TypeError, ValueError) as error:
            raise DatasetError(path, f"is damaged ({error}): render the set again") from error
        self._samples = [
            TrainSample(scene / "rgb" / f"{image_name(labels.index)}.jpg", labels)
            for scene in scenes_in(folder)
            if (scene / LABELS_NAME).is_file()
            for labels in read_labels(scene / LABELS_NAME)
        ]
        if not self._samples:
            raise DatasetError(folder, "holds no image: render the set again")

    def __len__(self) -> int:
        return len(self._samples)

    def __getitem__(self, place: int) -> TrainSample:
        return self._samples[place]

    def __iter__(self) -> Iterator[TrainSample]:
        return iter(self._samples)

    def selected(self, *, validation: bool, assembled: bool | None = None) -> list[TrainSample]:
        """Images to train on or those kept for validation; with joined parts, without, or both."""
        return [
            sample
            for sample in self._samples
            if sample.labels.is_validation == validation
            and assembled in (None, sample.labels.is_assembled)
        ]
