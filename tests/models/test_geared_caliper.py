"""The Geared Caliper: its gears mesh, its beam slides and is held, its plates and teeth."""

import math

import manifold3d
import numpy as np
import pytest
from bundled_assets import LARGEST_OVERLAP_MM3, moved

from snapfit.models.assets import geared_caliper as caliper
from snapfit.models.assets.solids_plates import filleted, gear_outline, opening, plate, rectangle
from snapfit.models.pose import Pose

ASSET = "geared-caliper"


@pytest.mark.parametrize(
    ("one", "other"), [("gear-large", "roller"), ("gear-large", "gear-small"), ("roller", "fix")]
)
def test_teeth_stand_in_the_gaps_of_the_other_gear(bundle, solids, links, one, other):
    """Turned by half a tooth they would collide."""
    there = bundle.placed()
    n_teeth = {"gear-large": 36, "roller": 12 if other == "fix" else 20}[one]
    turned = links[one].parent_from_child @ Pose.exp([0, 0, math.pi / n_teeth, 0, 0, 0])
    assert (moved(solids[one], turned) ^ there[other]).volume() > 3


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 1.0])
def test_the_beam_slides_freely_between_the_limits_of_its_joint(bundle, solids, links, share):
    link = links["fix"]
    low, high = link.joint.travel_m
    travel = Pose.from_translation(low + share * (high - low), 0, 0)
    beam = moved(solids["fix"], link.parent_from_child @ travel)
    there = bundle.placed()
    for name in ("move-bottom", "move-top-vernier", "gear-large", "gear-small"):
        assert (beam ^ there[name]).volume() < LARGEST_OVERLAP_MM3, name


def test_the_jaws_touch_at_the_end_of_the_travel(solids, links):
    link = links["fix"]
    beyond = Pose.from_translation(link.joint.travel_m[1] + 0.0005, 0, 0)
    closed = moved(solids["fix"], link.parent_from_child @ beyond)
    assert (closed ^ solids["move-bottom"]).volume() > 50


def test_the_cover_holds_the_beam_in_the_channel(bundle, solids, links):
    there = bundle.placed()
    lifted = there["fix"].translate([0, 0, 2])
    assert (lifted ^ solids["move-bottom"]).volume() < LARGEST_OVERLAP_MM3
    assert (lifted ^ there["move-top-vernier"]).volume() > 10


def test_the_manifest_agrees_with_the_dimensions_of_the_script(links):
    base = np.array(caliper.ORIGIN_MM["move-bottom"])
    turns = caliper.gear_turn_rad()
    for name, link in links.items():
        there = np.array(caliper.ORIGIN_MM[name]) - base
        np.testing.assert_allclose(link.parent_from_child.translation * 1000, there, atol=1e-3)
        turn = [0, 0, turns[name]] if name in turns else [-math.pi / 2, 0, 0]
        assert link.parent_from_child.angle_to(Pose.exp([*turn, 0, 0, 0])) < 1e-5
    np.testing.assert_allclose(np.array(links["fix"].joint.travel_m) * 1000, caliper.FIX_TRAVEL_MM)


def test_a_fillet_is_tangent_to_both_sides_inwards_and_outwards():
    outline = filleted([(0, 0, 0), (10, 0, 0), (10, 10, 2), (5, 10, 0), (5, 5, 2), (0, 5, 0)])
    area = float(manifold3d.CrossSection([outline]).area())
    corner = 4 - math.pi
    # A corner cut outside and one filled inside: equal and opposite.
    assert area == pytest.approx(75, abs=0.1)
    assert float(manifold3d.CrossSection([rectangle((0, 9), (0, 9), 2)]).area()) == pytest.approx(
        81 - 4 * corner, abs=0.2
    )


def test_a_plate_and_its_opening_are_chamfered_outwards():
    square, hole = rectangle((0, 20), (0, 20)), rectangle((5, 15), (5, 15))
    solid = plate(square, (0, 5), 1.0)
    assert solid.slice(0.001).area() == pytest.approx(18**2, abs=0.1)
    assert solid.slice(2.5).area() == pytest.approx(20**2, abs=0.1)
    cut = solid - opening(hole, (0, 5), 1.0)
    assert cut.slice(2.5).area() == pytest.approx(300, abs=0.1)
    assert cut.slice(4.999).area() == pytest.approx(18**2 - 12**2, abs=0.2)


@pytest.mark.parametrize("n_teeth", [12, 20, 36])
def test_gears_have_their_teeth_between_root_and_tip(n_teeth):
    radii = np.linalg.norm(gear_outline(n_teeth), axis=1)
    assert radii.max() == pytest.approx(n_teeth / 2 + 0.95)
    assert radii.min() == pytest.approx(n_teeth / 2 - 1.25)
