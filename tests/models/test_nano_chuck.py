"""The Nano Chuck: its threads, ball and slider hold what they should hold."""

import math

import numpy as np
import pytest
from bundled_assets import LARGEST_OVERLAP_MM3, along, moved

from snapfit.models.assets import nano_chuck as chuck
from snapfit.models.assets import nano_chuck_vise as vise
from snapfit.models.pose import Pose

ASSET = "nano-chuck"


@pytest.mark.parametrize("name", ["screw", "nut", "vise-base", "vise-screw"])
def test_screws_cannot_be_pushed_through_their_threads(solids, links, name):
    link = links[name]
    push = Pose.from_translation(*(-0.0015 * np.array(link.joint.axis)))
    pushed = moved(solids[name], link.parent_from_child @ push)
    assert (solids[link.parent] ^ pushed).volume() > 10


@pytest.mark.parametrize("turn_deg", [17.0, 45.0, 90.0])
def test_the_headplate_swivels_on_the_tip_and_cannot_be_pulled_off(solids, links, turn_deg):
    link = links["headplate"]
    turned = link.parent_from_child @ Pose.exp([0, 0, math.radians(turn_deg), 0, 0, 0])
    assert (solids["screw"] ^ moved(solids["headplate"], turned)).volume() < LARGEST_OVERLAP_MM3
    pulled = turned @ Pose.from_translation(0, 0, 0.003)
    assert (solids["screw"] ^ moved(solids["headplate"], pulled)).volume() > 5


def test_the_nut_holds_the_ball_which_alone_can_be_lifted_out(solids, links):
    ball, nut = links["balljoint"].parent_from_child, links["nut"].parent_from_child
    for lift_mm in (2, 6, 12):
        lifted = moved(solids["balljoint"], Pose.from_translation(0, 0, lift_mm / 1000) @ ball)
        assert (solids["base"] ^ lifted).volume() < LARGEST_OVERLAP_MM3
        assert (moved(solids["nut"], nut) ^ lifted).volume() > 10


def test_the_slider_can_be_lifted_out_only_at_the_wide_end_of_the_slot(solids, links):
    link = links["vise-slider"]
    for share, is_free in ((0.0, True), (0.6, False)):
        lifted = Pose.from_translation(0, 0, 0.003) @ link.parent_from_child
        pose = lifted @ along(link.joint, share)
        overlap = (solids["vise-base"] ^ moved(solids["vise-slider"], pose)).volume()
        assert (overlap < LARGEST_OVERLAP_MM3) == is_free


def test_the_manifest_agrees_with_the_dimensions_of_the_script(links):
    expected_mm = {
        "screw": chuck.SCREW_IN_BASE_MM,
        "headplate": chuck.HEADPLATE_ON_SCREW_MM,
        "balljoint": chuck.BALL_IN_BASE_MM,
        "nut": chuck.NUT_IN_BASE_MM,
        "vise-base": chuck.VISE_ON_BALL_MM,
        "vise-slider": vise.SLIDER_IN_VISE_MM,
        "vise-screw": vise.SCREW_IN_VISE_MM,
    }
    assert links.keys() == expected_mm.keys()
    for name, position_mm in expected_mm.items():
        position = links[name].parent_from_child.translation * 1000
        np.testing.assert_allclose(position, position_mm, atol=1e-9)
    leads_mm = {
        "screw": chuck.SCREW_LEAD_MM,
        "nut": chuck.NUT_LEAD_MM,
        "vise-base": vise.STUD_LEAD_MM,
        "vise-screw": vise.VISE_SCREW_LEAD_MM,
    }
    pitches = {n: link.joint.pitch_m * 1000 for n, link in links.items() if link.joint.pitch_m}
    assert pitches == pytest.approx(leads_mm)
    travel = np.array(links["vise-slider"].joint.travel_m) * 1000
    np.testing.assert_allclose(travel, vise.SLIDER_TRAVEL_MM)
