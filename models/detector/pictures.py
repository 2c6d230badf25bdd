"""Training images in memory: all of them on a GPU that has room, otherwise a few at a time."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol

import cv2
import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from snapfit.models.detector.device import Workplace
from snapfit.models.train_reader import TrainSample

_SHARE_OF_MEMORY = 0.5


class Pictures(Protocol):
    """Where the images of a training come from."""

    def expect(self, places: Sequence[int]) -> None:
        """These are asked for next: they may be read meanwhile."""

    def take(self, places: Sequence[int]) -> tuple[Tensor, Tensor]:
        """(n, H * W) int32 images as `cutting.cut_out` wants them, and the row of each place.

        Raises:
            DatasetError: an image is missing or cannot be decoded.
        """


class HeldPictures:
    """All images, decoded, on the device.

    Attributes:
        memory: (N, H * W) int32, as `cutting.cut_out` wants them.
    """

    def __init__(self, samples: Sequence[TrainSample], place: Workplace) -> None:
        """Reads all of them.

        Raises:
            DatasetError: an image is missing or cannot be decoded.
        """
        self._device = place.device
        first = packed(samples[0])
        self.memory = torch.empty((len(samples), first.size), dtype=torch.int32)
        self.memory = self.memory.to(place.device)
        with ThreadPoolExecutor(place.workers) as threads:
            for row, image in enumerate(threads.map(packed, samples)):
                self.memory[row] = torch.from_numpy(image)

    def expect(self, places: Sequence[int]) -> None:
        """As in `Pictures`; they are there."""

    def take(self, places: Sequence[int]) -> tuple[Tensor, Tensor]:
        """As in `Pictures`."""
        return self.memory, torch.tensor(places, device=self._device)


class ReadPictures:
    """Images that are read, in threads, when they are needed."""

    def __init__(self, samples: Sequence[TrainSample], place: Workplace) -> None:
        self._samples, self._device = samples, place.device
        self._threads = ThreadPoolExecutor(max(1, place.workers))
        self._coming: dict[int, Future[npt.NDArray[np.int32]]] = {}

    def expect(self, places: Sequence[int]) -> None:
        """As in `Pictures`."""
        for place in places:
            if place not in self._coming:
                self._coming[place] = self._threads.submit(packed, self._samples[place])

    def take(self, places: Sequence[int]) -> tuple[Tensor, Tensor]:
        """As in `Pictures`."""
        self.expect(places)
        there = sorted(set(places))
        images = [self._coming.pop(place).result() for place in there]
        memory = torch.from_numpy(np.stack(images)).to(self._device)
        rows = np.searchsorted(there, places)
        return memory, torch.from_numpy(rows).to(self._device)


def pictures_for(samples: Sequence[TrainSample], place: Workplace) -> Pictures:
    """The images, held on a GPU where they fit into half of what is free there.

    Raises:
        DatasetError: an image is missing or cannot be decoded.
    """
    if place.device.type == "cuda":
        camera = samples[0].labels.camera
        needed = 4 * len(samples) * camera.width * camera.height
        free, _ = torch.cuda.mem_get_info(place.device)
        if needed < _SHARE_OF_MEMORY * free:
            return HeldPictures(samples, place)
    return ReadPictures(samples, place)


def packed(sample: TrainSample) -> npt.NDArray[np.int32]:
    """(H * W,) an image with a pixel in each number: blue in the lowest byte, green, red.

    Raises:
        DatasetError: it is missing or cannot be decoded.
    """
    four = cv2.cvtColor(sample.image(), cv2.COLOR_BGR2BGRA)
    return np.ascontiguousarray(four).view(np.int32).ravel()
