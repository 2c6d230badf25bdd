"""Fits an image into the network's input without changing its proportions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.detector.card import STRIDE

_PADDING = 114


@dataclass(frozen=True)
class Letterbox:
    """An image scaled into an input, with grey around it where it does not fill it.

    Attributes:
        image_width, image_height: px.
        input_width, input_height: px.
    """

    image_width: int
    image_height: int
    input_width: int
    input_height: int

    @property
    def scale(self) -> float:
        """Pixels of the input for each of the image."""
        return min(self.input_width / self.image_width, self.input_height / self.image_height)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the scaled image, px."""
        width, height = self.image_width * self.scale, self.image_height * self.scale
        return max(1, round(width)), max(1, round(height))

    @property
    def offset(self) -> tuple[int, int]:
        """Columns and rows of grey to the left and above."""
        width, height = self.size
        return (self.input_width - width) // 2, (self.input_height - height) // 2

    def apply(self, color: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """(1, 3, input_height, input_width) float32, red first, 0 to 1, of (H, W, 3) blue first."""
        (width, height), (left, top) = self.size, self.offset
        shape = self.input_height, self.input_width, 3
        filled = np.full(shape, _PADDING, dtype=np.uint8)
        goal = filled[top : top + height, left : left + width]
        if (width, height) == (self.image_width, self.image_height):
            goal[:] = color
        else:
            goal[:] = cv2.resize(color, (width, height), interpolation=cv2.INTER_LINEAR)
        blob = cv2.dnn.blobFromImage(filled, scalefactor=1 / 255, swapRB=True)
        return np.asarray(blob, dtype=np.float32)

    def to_image(self, places: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """(..., 2) places in the input to pixels of the image.

        The input's edge is at 0; the image's pixel centres are at integers.

        The scaled image has whole pixels, so its sides are scaled by slightly different factors.
        """
        (width, height), offset = self.size, self.offset
        factors = self.image_width / width, self.image_height / height
        pixels: npt.NDArray[np.float64] = (places - np.array(offset)) * np.array(factors) - 0.5
        return pixels


def free_input_size(
    image: tuple[int, int], card: tuple[int, int], stride: int = STRIDE
) -> tuple[int, int]:
    """Width and height of the input for an image, where the network takes any size.

    The longer side is that of the card; the shorter follows the image, so that little of the input
    is grey.

    Args:
        image: width and height, px.
        card: width and height that the network is meant for, px.
        stride: both are multiples of it.
    """
    width, height = image
    longest = max(card)
    shorter = math.ceil(longest * min(width, height) / max(width, height) / stride) * stride
    return (longest, shorter) if width >= height else (shorter, longest)
