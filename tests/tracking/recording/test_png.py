"""PNG: OpenCV reads the same pixels, whatever they are."""

from __future__ import annotations

import zlib

import cv2
import numpy as np
import pytest

from snapfit.tracking.recording import png

SHAPES = [(1, 1), (1, 7), (5, 1), (48, 64), (33, 47)]


def images(shape: tuple[int, int], seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    color = rng.integers(0, 256, (*shape, 3)).astype(np.uint8)
    depth = rng.integers(0, 65536, shape).astype(np.uint16)
    smooth = (np.arange(shape[0] * shape[1]) * 7).reshape(shape).astype(np.uint16)
    return [color, depth, smooth, np.zeros_like(color), np.full(shape, 65535, np.uint16)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("library", ["isal", "zlib"])
def test_opencv_reads_the_same_pixels(
    shape: tuple[int, int], library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if library == "zlib":
        monkeypatch.setattr(png, "_deflate", zlib)
    else:
        pytest.importorskip("isal")
    for image in images(shape, seed=sum(shape)):
        data = png.encode_png(image)
        read = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert read.dtype == image.dtype
        assert np.array_equal(read, image)


def test_parts_of_an_image_are_written_too() -> None:
    """What is no array of its own, as a view is."""
    whole = images((48, 64), seed=2)[0]
    part = whole[4:20, 8:40]
    read = cv2.imdecode(np.frombuffer(png.encode_png(part), np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(read, part)
