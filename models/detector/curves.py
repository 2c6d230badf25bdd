"""Loss curves of a training as a picture, drawn by OpenCV: training needs no plotting library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.errors import PictureError

_WIDTH, _HEIGHT, _MARGIN = 960, 540, 60
_COLORS = (
    (40, 40, 40),
    (60, 60, 220),
    (60, 160, 60),
    (220, 120, 40),
    (30, 160, 230),
    (170, 60, 170),
)
_INK, _GRID, _PAPER = (60, 60, 60), (225, 225, 225), (255, 255, 255)


def write_curves(history: Mapping[str, Sequence[float]], path: Path) -> None:
    """Writes each loss over the steps, smoothed, on a logarithmic scale.

    Args:
        history: losses by name, one value a step.
        path: of the PNG.

    Raises:
        PictureError: the file cannot be written.
    """
    picture = np.full((_HEIGHT, _WIDTH, 3), _PAPER, dtype=np.uint8)
    curves = {name: smoothed(values) for name, values in history.items() if len(values) > 1}
    if curves:
        _draw(picture, curves)
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), picture):
        raise PictureError(path, "cannot be written: is there room, and may you write there?")


def smoothed(values: Sequence[float]) -> npt.NDArray[np.float64]:
    """Moving means over a hundredth of the steps, one for each place of the window."""
    window = max(1, len(values) // 100)
    sums = np.cumsum(np.concatenate([[0.0], np.asarray(values, dtype=np.float64)]))
    means: npt.NDArray[np.float64] = (sums[window:] - sums[:-window]) / window
    return means


def _draw(picture: npt.NDArray[np.uint8], curves: Mapping[str, npt.NDArray[np.float64]]) -> None:
    logs = {name: np.log10(np.maximum(values, 1e-4)) for name, values in curves.items()}
    low = min(float(values.min()) for values in logs.values())
    high = max(float(values.max()) for values in logs.values())
    low, high = np.floor(low * 2) / 2, np.ceil(high * 2 + 1e-9) / 2
    n_steps = max(len(values) for values in logs.values())

    def place(step: float, log: float) -> tuple[int, int]:
        x = _MARGIN + step / max(n_steps - 1, 1) * (_WIDTH - 2 * _MARGIN)
        y = _HEIGHT - _MARGIN - (log - low) / (high - low) * (_HEIGHT - 2 * _MARGIN)
        return round(x), round(y)

    for log in np.arange(low, high + 0.25, 0.5):
        left = place(0, log)
        cv2.line(picture, left, place(n_steps - 1, log), _GRID, 1)
        _write(picture, f"{10**log:.3g}", (4, left[1] + 4), _INK)
    for share in (0.0, 0.5, 1.0):
        x, y = place(share * (n_steps - 1), low)
        _write(picture, str(round(share * n_steps)), (x - 16, y + 20), _INK)
    _write(picture, "steps", (_WIDTH // 2 - 20, _HEIGHT - 12), _INK)
    for i, (name, values) in enumerate(logs.items()):
        color = _COLORS[i % len(_COLORS)]
        line = np.array([place(k, log) for k, log in enumerate(values)], dtype=np.int32)
        cv2.polylines(
            picture, [line], isClosed=False, color=color, thickness=2, lineType=cv2.LINE_AA
        )
        _write(picture, name, (_MARGIN + 10 + 150 * i, _MARGIN - 24), color)


def _write(
    picture: npt.NDArray[np.uint8], text: str, at: tuple[int, int], color: tuple[int, int, int]
) -> None:
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, color, 1, cv2.LINE_AA)
