"""Fitting images into the network's input, and places back."""

import numpy as np
import pytest

from snapfit.tracking.detection.letterbox import Letterbox, free_input_size


@pytest.mark.parametrize(
    ("image", "given"),
    [
        ((1280, 720), (640, 384)),
        ((640, 480), (640, 384)),
        ((333, 517), (416, 288)),
        ((64, 64),) * 2,
    ],
)
def test_a_place_comes_back(image, given):
    """A bright spot is found where it was put, within a pixel of the input."""
    box = Letterbox(*image, *given)
    color = np.zeros((image[1], image[0], 3), dtype=np.uint8)
    u, v = image[0] // 3, image[1] // 2
    color[v - 3 : v + 4, u - 3 : u + 4] = 255
    blob = box.apply(color)
    assert blob.shape == (1, 3, given[1], given[0])
    assert blob.dtype == np.float32
    weight = blob[0, 0] * (np.abs(blob[0, 0] - 114 / 255) > 0.01)
    rows, columns = np.indices(weight.shape)
    # The middle of the first pixel is at one half.
    place = (
        (weight * columns).sum() / weight.sum() + 0.5,
        (weight * rows).sum() / weight.sum() + 0.5,
    )
    found = box.to_image(np.array([place], dtype=np.float32))[0]
    assert np.abs(found - (u, v)).max() < 0.6


def test_red_comes_first_and_what_is_not_filled_is_grey():
    color = np.zeros((64, 128, 3), dtype=np.uint8)
    color[..., 2] = 255
    blob = Letterbox(128, 64, 128, 128).apply(color)[0]
    assert blob[:, 64, 64].tolist() == [1, 0, 0]
    assert blob[:, 0, 0] == pytest.approx([114 / 255] * 3)
    assert blob[0, 32:96].min() == 1
    assert blob[0, :32].max() < 0.5


@pytest.mark.parametrize(
    ("image", "expected"),
    [((1280, 720), (640, 384)), ((640, 480), (640, 480)), ((480, 640), (480, 640))],
)
def test_a_free_input_is_as_large_as_the_image_needs(image, expected):
    assert free_input_size(image, (640, 384)) == expected
