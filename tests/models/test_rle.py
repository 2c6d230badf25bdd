"""Masks as run lengths: COCO's own text, back to the same mask, and damage is told."""

import numpy as np
import pytest

from snapfit.models.rle import decode_mask, encode_mask


def test_any_mask_comes_back():
    rng = np.random.default_rng(0)
    for _ in range(60):
        shape = tuple(rng.integers(1, 40, 2))
        mask = rng.random(shape) < rng.random() ** 2
        np.testing.assert_array_equal(decode_mask(encode_mask(mask), *shape), mask)


@pytest.mark.parametrize("value", [False, True])
def test_nothing_and_everything(value):
    mask = np.full((5, 7), value)
    np.testing.assert_array_equal(decode_mask(encode_mask(mask), 5, 7), mask)


def test_the_text_is_that_of_the_format():
    """Runs of 6, 1, 40, 4, 5, 3 and 21, worked out by hand from the published algorithm."""
    flat = np.repeat(np.arange(7) % 2 == 1, [6, 1, 40, 4, 5, 3, 21])
    # 6; 1; 40 in two characters; then 4-1, 5-40, 3-4 and 21-5, with their signs.
    assert encode_mask(flat.reshape(8, 10).T) == "61X13mNO`0"


@pytest.mark.parametrize("text", ["", "6", "61X1", "\x7f", "61h"])
def test_damage_is_told(text):
    with pytest.raises(ValueError, match="run lengths"):
        decode_mask(text, 10, 8)
