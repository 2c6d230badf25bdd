"""No contour is looked for where a part of like colour begins."""

import numpy as np
import pytest
from scenes import images_of

from snapfit.tracking.kernels.region import runs_into_alike

SCALE = np.float32(0.25)


@pytest.fixture
def images():
    """Body 1 fills the right half of an image of 160 px, body 0 looks at its border."""
    near_id = np.zeros((40, 40), dtype=np.uint8)
    near_id[:, 20:] = 2
    near_id[:, :20] = 1
    images = images_of(n_bodies=2)
    return images._replace(near_id=near_id, alike=np.array([[0, 1], [1, 0]], dtype=np.uint8))


def checked(images, u: float, nu: float) -> bool:
    return bool(
        runs_into_alike(
            0, images, np.float32(u), np.float32(80), np.float32(nu), np.float32(0), SCALE
        )
    )


def test_a_border_to_a_like_body_is_no_contour(images) -> None:
    assert checked(images, 78.0, 1.0)


def test_the_outer_side_and_places_far_away_are_contours(images) -> None:
    assert not checked(images, 78.0, -1.0)
    assert not checked(images, 40.0, 1.0)


def test_bodies_of_other_colours_do_not_matter(images) -> None:
    other = images._replace(alike=np.zeros((2, 2), dtype=np.uint8))
    assert not checked(other, 78.0, 1.0)


def test_beyond_the_image_there_is_nothing(images) -> None:
    assert not checked(images, 159.0, 1.0)
    assert not checked(images, 1.0, -1.0)
