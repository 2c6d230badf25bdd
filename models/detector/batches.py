"""Batches of training samples for PyTorch, the same from the same seed wherever a run goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from snapfit.models.detector.samples import Sample, training_sample, whole_sample
from snapfit.models.detector.shapes import PartShape
from snapfit.models.detector.targets import Targets
from snapfit.models.detector.views import ViewParameters
from snapfit.models.train_reader import TrainSample

Batch = tuple[Tensor, Targets]

# Six tiles show three parts of each image, which is decoded once.
_IMAGES_A_VIEW = 2


@dataclass(frozen=True, eq=False)
class Course(Dataset[Sample]):
    """An endless row of views: each round shows every image once, in another order.

    Attributes:
        samples: the images.
        shapes: of the parts.
        parameters: of the views.
        seed: of order and views; view n depends on the seed and n alone.
    """

    samples: Sequence[TrainSample]
    shapes: Mapping[str, PartShape]
    parameters: ViewParameters
    seed: int

    def __getitem__(self, place: int) -> Sample:
        # OpenCV's own threads would fight with those of the training.
        cv2.setNumThreads(0)
        rng = np.random.default_rng((self.seed, 1, place))
        first = place * _IMAGES_A_VIEW
        images = [self._image(first + i) for i in range(_IMAGES_A_VIEW)]
        return training_sample(images, self.shapes, self.parameters, rng)

    def _image(self, place: int) -> TrainSample:
        number, within = divmod(place, len(self.samples))
        order = np.random.default_rng((self.seed, 0, number)).permutation(len(self.samples))
        return self.samples[int(order[within])]


def training_batches(
    course: Course, batch: int, steps: range, *, workers: int, pinned: bool
) -> Iterator[Batch]:
    """The batches of some steps: images (B, 3, H, W) uint8, red first, and what is true in them.

    Args:
        course: where they come from.
        batch: images in each.
        steps: numbers of the batches.
        workers: processes that make them beside the training; 0 makes them in this one.
        pinned: whether they lie in memory from which a GPU copies fast.
    """
    settings: dict[str, Any] = {}
    if workers:
        # Forking a process with threads can leave a lock held for ever.
        settings = {"multiprocessing_context": "spawn", "prefetch_factor": 4}
    loader: DataLoader[Sample] = DataLoader(
        course,
        batch_size=batch,
        sampler=range(steps.start * batch, steps.stop * batch),
        collate_fn=collated,
        num_workers=workers,
        pin_memory=pinned,
        **settings,
    )
    for images, *pieces in loader:
        yield images, Targets(*pieces)


def whole_batches(
    samples: Sequence[TrainSample],
    shapes: Mapping[str, PartShape],
    parameters: ViewParameters,
    batch: int,
) -> Iterator[Batch]:
    """Images as they are, in order."""
    for start in range(0, len(samples), batch):
        few = samples[start : start + batch]
        images, *pieces = collated([whole_sample(each, shapes, parameters) for each in few])
        yield images, Targets(*pieces)


def collated(samples: list[Sample]) -> tuple[Tensor, ...]:
    """Images, and the pieces of `Targets` in their order, filled up to the most parts."""
    most = max(1, *(len(sample.classes) for sample in samples))
    n_keypoints = samples[0].keypoints.shape[1]
    count = len(samples)
    classes = np.full((count, most), -1, dtype=np.int64)
    boxes = np.zeros((count, most, 4), dtype=np.float32)
    keypoints = np.zeros((count, most, n_keypoints, 3), dtype=np.float32)
    ignored = np.zeros((count, most), dtype=np.bool_)
    for i, sample in enumerate(samples):
        here = slice(0, len(sample.classes))
        classes[i, here], boxes[i, here] = sample.classes, sample.boxes
        keypoints[i, here], ignored[i, here] = sample.keypoints, sample.is_ignored
    pictures = np.stack([sample.picture[:, :, ::-1].transpose(2, 0, 1) for sample in samples])
    pieces = pictures, classes, boxes, keypoints, ignored
    return tuple(torch.from_numpy(np.ascontiguousarray(each)) for each in pieces)
