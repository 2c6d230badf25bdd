"""Views of training images: cut out, turned, scaled, and in another light; never mirrored.

A mirrored part is another part. Turning the picture about the principal point is the same as
rolling the camera, so it can be undone in the poses: a symmetric part's canonical pose, and with it
its keypoints, is found anew for the rolled camera.

Places here are those of the public YOLO layout: the left edge of the image is 0, the middle of the
first pixel 0.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array, Pose

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


@dataclass(frozen=True, eq=False)
class View:
    """A cut-out of an image.

    Attributes:
        matrix: (2, 3) view from image, px, edges at 0.
        roll_rad: by which the camera is rolled, so that content turns from x to y.
        width, height: px.
    """

    matrix: Array
    roll_rad: float
    width: int
    height: int

    def places(self, pixels: Array) -> Array:
        """(..., 2) image pixels (centres at integers) to places in the view."""
        result: Array = (pixels + 0.5) @ self.matrix[:, :2].T + self.matrix[:, 2]
        return result

    def picture(self, image: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        """(height, width, 3) uint8: the view of an image (H, W, 3)."""
        matrix = self.matrix.copy()
        # OpenCV counts from the middle of the first pixel.
        matrix[:, 2] += matrix[:, :2] @ (0.5, 0.5) - 0.5
        size, border = (self.width, self.height), (PADDING, PADDING, PADDING)
        warped = cv2.warpAffine(image, matrix, size, flags=cv2.INTER_LINEAR, borderValue=border)
        return np.asarray(warped, dtype=np.uint8)

    @property
    def unrolled(self) -> Pose:
        """The camera as it was from the camera as it is rolled."""
        return Pose.exp([0, 0, -self.roll_rad, 0, 0, 0])


def centered_view(size: tuple[int, int], parameters: ViewParameters) -> View:
    """The whole image (width, height), as large as it fits, in the middle of the view."""
    width, height = size
    scale = min(parameters.width_px / width, parameters.height_px / height)
    offset = (parameters.width_px - scale * width) / 2, (parameters.height_px - scale * height) / 2
    matrix = np.array([[scale, 0, offset[0]], [0, scale, offset[1]]], dtype=np.float64)
    return View(matrix, 0.0, parameters.width_px, parameters.height_px)


def sampled_view(
    size: tuple[int, int],
    part: Array | None,
    parameters: ViewParameters,
    rng: np.random.Generator,
) -> View:
    """A view at random.

    Args:
        size: width and height of the image, px.
        part: (4,) left, top, right, bottom of a part, px, that lies somewhere in most views; None
            for any place.
        parameters: what a view is like.
        rng: where chance comes from.
    """
    width, height = parameters.width_px, parameters.height_px
    scale = parameters.across_px / size[0] * parameters.zoom ** rng.uniform(-1, 1)
    is_aimed = part is not None and rng.random() < parameters.aimed_share
    aim = rng.uniform((0, 0), size)
    if part is not None and is_aimed:
        aim = (part[:2] + part[2:]) / 2
        # A part that is larger than the view is made to fit, nearly.
        scale = min(scale, 1.1 * min(width, height) / float((part[2:] - part[:2]).max()))
    roll = math.radians(parameters.roll_deg) * rng.normal()
    turn = scale * np.array(
        [[math.cos(roll), -math.sin(roll)], [math.sin(roll), math.cos(roll)]], dtype=np.float64
    )
    border = parameters.border_share * np.array([width, height])
    goal = rng.uniform(border, (width, height) - border)
    offset = goal - turn @ (aim + 0.5)
    # What lies beyond the image teaches nothing: leave little of it in the view.
    middle = turn @ (np.array(size, dtype=np.float64) / 2) + offset
    slack = np.abs(scale * np.array(size) - (width, height)) / 2 + 0.06 * np.array([width, height])
    wished = middle - (width / 2, height / 2)
    offset += np.clip(wished, -slack, slack) - wished
    return View(np.column_stack([turn, offset]), roll, width, height)


def relit(
    picture: npt.NDArray[np.uint8], parameters: ViewParameters, rng: np.random.Generator
) -> npt.NDArray[np.uint8]:
    """(H, W, 3) the picture in another light: brightness, tint, contrast."""
    gain = math.exp(parameters.gain * rng.normal())
    gains = gain * np.exp(parameters.tint * rng.normal(size=3))
    contrast = math.exp(parameters.contrast * rng.normal())
    levels = np.arange(256, dtype=np.float64)[:, None] * gains
    curves = (levels - 127.5) * contrast + 127.5
    table = np.clip(curves, 0, 255).astype(np.uint8)[None]
    return np.asarray(cv2.LUT(picture, table), dtype=np.uint8)
