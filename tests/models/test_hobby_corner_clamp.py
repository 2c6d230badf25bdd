"""The Hobby Corner Clamp: how its jaw slides and lifts out, and its bolt holds."""

import math

import numpy as np
import pytest
from bundled_assets import LARGEST_OVERLAP_MM3, moved

from snapfit.models.assets import hobby_corner_clamp as clamp
from snapfit.models.assets.solids import thread
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry

ASSET = "hobby-corner-clamp"


def test_the_jaw_can_be_lifted_out_only_at_the_wide_end_of_the_slot(solids, links):
    link = links["jaw"]
    for travel_m, is_free in ((link.joint.travel_m[0], True), (0.0, False)):
        lifted = link.parent_from_child @ Pose.from_translation(travel_m, 0, 0.003)
        overlap = (solids["base"] ^ moved(solids["jaw"], lifted)).volume()
        assert (overlap < LARGEST_OVERLAP_MM3) == is_free


@pytest.mark.parametrize("share", [0.0, 0.37, 0.71])
def test_the_bolt_turns_in_its_thread_and_cannot_be_pushed_through(solids, links, share):
    link = links["bolt"]
    travel_m = share * link.joint.travel_m[0]
    turn = 2 * math.pi * travel_m / link.joint.pitch_m
    screwed = link.parent_from_child @ Pose.exp([0, 0, turn, 0, 0, travel_m])
    assert (solids["base"] ^ moved(solids["bolt"], screwed)).volume() < LARGEST_OVERLAP_MM3
    pushed = screwed @ Pose.from_translation(0, 0, 0.0015)
    assert (solids["base"] ^ moved(solids["bolt"], pushed)).volume() > 10


def test_the_orientation_of_the_bolt_counts_modulo_thirds_of_a_turn(bundle):
    turned = Pose.exp([0, 0, math.radians(121), 0, 0, 0])
    error_m, error_rad = distance_modulo_symmetry(
        turned, Pose.identity(), bundle.parts["bolt"].symmetry
    )
    assert error_m == pytest.approx(0, abs=1e-9)
    assert math.degrees(error_rad) == pytest.approx(1, abs=1e-6)


def test_the_manifest_agrees_with_the_dimensions_of_the_script(links):
    jaw, bolt = links["jaw"], links["bolt"]
    np.testing.assert_allclose(jaw.parent_from_child.translation * 1000, clamp.JAW_IN_BASE_MM)
    np.testing.assert_allclose(np.array(jaw.joint.travel_m) * 1000, clamp.JAW_TRAVEL_MM)
    np.testing.assert_allclose(bolt.parent_from_child.translation * 1000, clamp.BOLT_IN_BASE_MM)
    assert bolt.joint.pitch_m * 1000 == pytest.approx(clamp.THREAD_LEAD_MM)
    assert bolt.joint.travel_m[0] * 1000 == pytest.approx(-clamp.BOLT_ENGAGED_MM)


def test_a_thread_is_a_helix():
    ridge = thread(5.0, 7.0, lead=6.0, starts=2, z=(0.0, 18.0))
    screwed = ridge.rotate([0, 0, 120]).translate([0, 0, 2.0])
    common = (ridge ^ screwed).volume() / ridge.volume()
    only_turned = (ridge ^ ridge.rotate([0, 0, 90])).volume() / ridge.volume()
    assert common > 16 / 18 - 0.01
    assert only_turned < 0.92
