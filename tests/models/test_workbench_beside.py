"""A second camera on the simulated bench."""

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.scene import looking_at
from snapfit.models.workbench.split import Condition

OPPOSITE = looking_at((-0.1, 0.5, 0.35), (0.0, -0.03, 0.04))
INDEX = 30


@pytest.fixture(scope="module")
def film() -> Film:
    return Film(find_asset("hobby-corner-clamp"), 60, 3, scale=0.25)


def test_both_cameras_see_the_same_things_at_the_same_time(film: Film) -> None:
    first = film.frame(INDEX, Condition.HAND)
    second = film.beside(OPPOSITE).frame(INDEX, Condition.HAND)
    assert second.state == first.state
    assert second.in_hand == first.in_hand
    for name, sighting in first.sightings.items():
        world_from_body = film.scene.camera_from_world.inverse() @ sighting.camera_from_body
        seen = second.sightings[name].camera_from_body
        np.testing.assert_allclose(seen.matrix, (OPPOSITE @ world_from_body).matrix, atol=1e-12)
    assert not np.array_equal(second.color, first.color)


def test_depth_is_that_of_the_second_camera(film: Film) -> None:
    """Where a part is seen, its middle lies about as deep as the depth image says."""
    frame = film.beside(OPPOSITE).frame(INDEX, Condition.NORMAL)
    base = frame.sightings["base"]
    measured = frame.depth[base.mask & (frame.depth > 0)] * 1e-3
    assert measured.size > 50
    assert np.median(measured) == pytest.approx(base.camera_from_body.translation[2], abs=0.06)


def test_a_camera_at_the_same_place_sees_the_same_with_other_noise(film: Film) -> None:
    first = film.frame(INDEX, Condition.NORMAL)
    second = film.beside(film.scene.camera_from_world).frame(INDEX, Condition.NORMAL)
    difference = second.color.astype(np.int16) - first.color
    assert difference.any()
    assert abs(difference.mean()) < 0.5
    assert np.abs(difference).mean() < 6
    for name, sighting in first.sightings.items():
        assert np.array_equal(second.sightings[name].mask, sighting.mask)


def test_the_first_camera_is_left_as_it_was(film: Film) -> None:
    before = film.frame(INDEX, Condition.ALL)
    film.beside(OPPOSITE).frame(INDEX, Condition.ALL)
    after = film.frame(INDEX, Condition.ALL)
    assert np.array_equal(before.color, after.color)
    assert np.array_equal(before.depth, after.depth)
