"""The LiftPod: its pins and rails hold, its sleeve comes off when it should."""

import numpy as np
import pytest
from bundled_assets import moved

from snapfit.models.assets import liftpod
from snapfit.models.pose import Pose

ASSET = "liftpod"


@pytest.mark.parametrize("child", ["arm-first", "arm-last", "bar", "clamp-frame"])
def test_the_pins_hold_what_is_hinged(solids, links, child):
    """Pulled away from the hinge by 2 mm, a pin meets its fork."""
    link = links[child]
    away = -np.array(link.joint.point_m)
    pulled = link.parent_from_child @ Pose.from_translation(*(0.002 * away / np.linalg.norm(away)))
    assert (solids[link.parent] ^ moved(solids[child], pulled)).volume() > 5


def test_the_sleeve_comes_off_only_before_the_clamp_is_mounted(bundle, links):
    before, after = bundle.links("sleeve-on-bar")["sleeve"], links["sleeve"]
    bar_end_m, half_sleeve_m = 0.0715, 0.036
    off_m = before.parent_from_child.translation[0] - before.joint.travel_m[0]
    assert off_m - half_sleeve_m > bar_end_m
    assert after.joint.travel_m[0] > before.joint.travel_m[0]


def test_the_rails_hold_the_slider(solids, links):
    link = links["clamp-slider"]
    for away in ((0, 0, 0.002), (0.002, 0, 0)):
        pulled = link.parent_from_child @ Pose.from_translation(*away)
        overlap = (solids["clamp-frame"] ^ moved(solids["clamp-slider"], pulled)).volume()
        assert overlap > 10, away


def test_the_manifest_agrees_with_the_dimensions_of_the_script(bundle, links):
    stated, made = links, liftpod.assembled()
    assert stated.keys() == made.keys()
    for name, (parent, pose) in made.items():
        assert stated[name].parent == parent
        assert stated[name].parent_from_child.distance_to(pose) < 1e-6, name
        assert stated[name].parent_from_child.angle_to(pose) < 1e-5, name
        if name in liftpod.HELD_AT_MM:
            held = np.array(stated[name].joint.point_m) * 1000
            np.testing.assert_allclose(held, liftpod.HELD_AT_MM[name])
    for name, child, travel_mm in (
        ("sleeve-on-bar", "sleeve", liftpod.SLEEVE_TRAVEL_MM),
        ("assembled", "sleeve", liftpod.SLEEVE_HELD_MM),
        ("assembled", "clamp-slider", liftpod.SLIDER_TRAVEL_MM),
    ):
        travel = np.array(bundle.links(name)[child].joint.travel_m) * 1000
        np.testing.assert_allclose(travel, travel_mm)
