"""What is true in a batch of images, as the losses want it."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Targets:
    """The parts in B images, filled up to M an image.

    Attributes:
        classes: (B, M) int64; -1 where there is none.
        boxes: (B, M, 4) left, top, right, bottom, px of the input.
        keypoints: (B, M, K, 3) x, y (px) and 1 where it is in the image, else 0.
        is_ignored: (B, M) whether the part is seen too little to be asked for; finding it
            nevertheless is no mistake.
    """

    classes: Tensor
    boxes: Tensor
    keypoints: Tensor
    is_ignored: Tensor

    @property
    def is_wanted(self) -> Tensor:
        """(B, M) parts that are to be found."""
        return (self.classes >= 0) & ~self.is_ignored

    def to(self, device: torch.device) -> Targets:
        """The same on another device."""
        pieces = [getattr(self, each.name) for each in fields(self)]
        return Targets(*(each.to(device, non_blocking=True) for each in pieces))


def at(values: Tensor, places: Tensor) -> Tensor:
    """(B, P, ...) of values (B, N, ...): those at places (B, P) of the same image."""
    rest = values.shape[2:]
    index = places.reshape(*places.shape, *[1] * len(rest))
    return values.gather(1, index.expand(-1, -1, *rest))
