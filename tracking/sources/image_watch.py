"""Notices images that no camera in order delivers: frozen, black, half, of the wrong size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.tracking.sources.driver import Images, LensedCamera


@dataclass(frozen=True)
class WatchParameters:
    """When an image counts as wrong.

    Attributes:
        frozen_after: the same bytes so many times running; a sensor's noise is never twice the
            same.
        black_below: a colour image without a brighter pixel, 0 to 255.
        half_share: so much of the image's height, at its lower end, in one colour: a transfer
            that broke off. White is left out, that can be an overexposed table.
    """

    frozen_after: int = 5
    black_below: int = 12
    half_share: float = 0.1


class ImageWatch:
    """Watches the images of one camera.

    Args:
        lensed: the camera.
        parameters: when an image counts as wrong.
    """

    def __init__(self, lensed: LensedCamera, parameters: WatchParameters | None = None) -> None:
        self._lensed = lensed
        self._parameters = parameters or WatchParameters()
        self._last: Images | None = None
        self._n_same = 0

    def problem(self, images: Images) -> str | None:
        """What is wrong with the next images; None if nothing is."""
        return self._wrong_size(images) or self._frozen(images) or self._empty(images.color)

    def _wrong_size(self, images: Images) -> str | None:
        camera = self._lensed.color
        shape = (camera.height, camera.width, 3)
        if images.color.shape != shape or images.color.dtype != np.uint8:
            return _told("colour", images.color, camera.width, camera.height)
        depth, size = images.depth, self._lensed.depth
        if depth is None or size is None:
            return None
        if depth.shape != (size.height, size.width) or depth.dtype != np.uint16:
            return _told("depth", depth, size.width, size.height)
        return None

    def _frozen(self, images: Images) -> str | None:
        is_same = self._last is not None and _same(images, self._last)
        self._n_same = self._n_same + 1 if is_same else 1
        self._last = images
        if self._n_same >= self._parameters.frozen_after:
            return "the camera delivers the same image again and again: it hangs"
        return None

    def _empty(self, color: npt.NDArray[np.uint8]) -> str | None:
        thin = color[:, ::8]
        if thin.max() < self._parameters.black_below:
            return "the colour image is black: is the lens covered, or the light out?"
        last = thin[-1, 0]
        n_rows = max(1, round(self._parameters.half_share * len(color)))
        is_plain = bool((thin[-n_rows:] == last).all()) and last.min() < 255
        if is_plain and not (thin == last).all():
            return "the lower part of the colour image is missing: the transfer broke off"
        return None


def _same(a: Images, b: Images) -> bool:
    if (a.depth is None) != (b.depth is None) or not np.array_equal(a.color, b.color):
        return False
    return a.depth is None or b.depth is None or np.array_equal(a.depth, b.depth)


def _told(which: str, image: npt.NDArray[Any], width: int, height: int) -> str:
    size = "x".join(str(n) for n in (*image.shape[1::-1], *image.shape[2:]))
    return f"the {which} image is {size} {image.dtype}, the camera's is {width}x{height}"
