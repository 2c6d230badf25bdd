"""What views of training images are like.

Places here are those of the public YOLO layout: the left edge of the image is 0, the middle of the
first pixel 0.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snapfit.models.pose import Array

PADDING = 114
"""Grey value around an image that does not fill the network's input."""


@dataclass(frozen=True)
class ViewParameters:
    """How far views of training images differ from the images.

    Attributes:
        across_px: what the whole image's width becomes before it is cut, px.
        height_px, width_px: of a view; multiples of 32.
        zoom: largest factor by which it is scaled further, up or down.
        roll_deg: standard deviation of the roll.
        gain, tint, contrast: spread of brightness, of each channel's, and of contrast.
        aimed_share: share of the views that are laid around a part; others lie anywhere.
        tiles: rows and columns of small views around parts that are shown beside each other.
        border_share: of a view's sides within which the part's middle does not lie.
        tiled_share: share of the views that are such tiles: they show more parts a pixel.
    """

    across_px: int = 640
    height_px: int = 256
    width_px: int = 384
    zoom: float = 1.35
    roll_deg: float = 8.0
    gain: float = 0.2
    tint: float = 0.06
    contrast: float = 0.15
    aimed_share: float = 0.85
    tiles: tuple[int, int] = (2, 3)
    tiled_share: float = 0.7
    border_share: float = 0.2


def centered(size: tuple[int, int], parameters: ViewParameters) -> Array:
    """(2, 3) view from image, px, edges at 0: the whole image, as large as it fits, in the middle.

    Args:
        size: width and height of the image, px.
        parameters: of the view.
    """
    width, height = size
    scale = min(parameters.width_px / width, parameters.height_px / height)
    offset = (parameters.width_px - scale * width) / 2, (parameters.height_px - scale * height) / 2
    return np.array([[scale, 0, offset[0]], [0, scale, offset[1]]], dtype=np.float64)
