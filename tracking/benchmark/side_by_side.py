"""Pictures of all methods side by side: the camera's image, then one overlay a method.

Up to three methods stand in one line with it, more of them in a grid.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.recording import Recording
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.sources.images import read_frame

Image = npt.NDArray[np.uint8]

_PANEL_WIDTH_PX = 640
_COLUMNS = 4


def panel_camera(camera: PinholeCamera) -> PinholeCamera:
    """The camera of one panel, scaled down to its width; both sides even, as films need it."""
    factor = min(1.0, _PANEL_WIDTH_PX / camera.width)
    scaled = camera.scaled(factor)
    width, height = (2 * max(length // 2, 1) for length in (scaled.width, scaled.height))
    return replace(scaled, width=width, height=height)


def picture_size_px(camera: PinholeCamera, n_methods: int) -> tuple[int, int]:
    """Width and height of a whole picture.

    Args:
        camera: from `panel_camera`.
        n_methods: how many methods are drawn beside the image.
    """
    n_columns = min(1 + n_methods, _COLUMNS)
    return camera.width * n_columns, camera.height * math.ceil((1 + n_methods) / n_columns)


def pictures(recording: Recording, runs: Sequence[Run]) -> Iterator[Image]:
    """Yields a picture (H, W, 3) uint8, BGR, for each frame.

    Args:
        recording: the sequence.
        runs: of each method on it.

    Raises:
        FrameError: an image cannot be read.
    """
    camera = panel_camera(recording.camera.color)
    # A method that is not shown every frame keeps its last picture.
    rows = [0] * len(runs)
    for files in recording.frames:
        frame = read_frame(files, recording.camera, 0)
        image = cv2.resize(frame.color, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
        state = recording.truth[files.name].state
        panels = [_labelled(image.copy(), f"{files.name}  {state or ''}")]
        for i, run in enumerate(runs):
            if rows[i] + 1 < len(run.frames) and run.frames[rows[i] + 1] == files.name:
                rows[i] += 1
            overlay = draw_overlay(image, camera, recording.parts, run.estimates(rows[i]))
            panels.append(_labelled(overlay, f"{run.method}  {run.states[rows[i]]}"))
        yield _grid(panels, picture_size_px(camera, len(runs)))


def _grid(panels: Sequence[Image], size_px: tuple[int, int]) -> Image:
    """The panels, line by line; what is left over is black."""
    height, width = panels[0].shape[:2]
    n_columns = size_px[0] // width
    whole = np.zeros((size_px[1], size_px[0], 3), dtype=np.uint8)
    for i, panel in enumerate(panels):
        y, x = height * (i // n_columns), width * (i % n_columns)
        whole[y : y + height, x : x + width] = panel
    return whole


def _labelled(image: Image, text: str) -> Image:
    """The image with a line of text that is legible on any ground."""
    for color, thickness in (((0, 0, 0), 3), ((255, 255, 255), 1)):
        cv2.putText(
            image, text, (8, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.5, color, thickness, cv2.LINE_AA
        )
    return image
