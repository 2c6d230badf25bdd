"""The Hand-Screw Clamp: its knobs and threads hold, its jaws can be told apart."""

import math

import numpy as np
import pytest
from bundled_assets import LARGEST_OVERLAP_MM3, along, base_from, moved

from snapfit.models.assets import hand_screw_clamp as clamp
from snapfit.models.pose import Pose

ASSET = "hand-screw-clamp"


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_jaw_2_glides_on_the_threads_and_meets_nothing_but_the_pad(solids, links, share):
    pose = links["jaw-2"].parent_from_child @ along(links["jaw-2"].joint, share)
    for name in ("thread-1", "thread-2", "pad"):
        other = moved(solids[name], links[name].parent_from_child)
        assert (other ^ moved(solids["jaw-2"], pose)).volume() < LARGEST_OVERLAP_MM3
    closer = moved(
        solids["jaw-2"], Pose.from_translation(0, 0, -0.0205) @ base_from("jaw-2", links)
    )
    assert (moved(solids["pad"], links["pad"].parent_from_child) ^ closer).volume() > 10


@pytest.mark.parametrize("name", ["knob-1", "knob-2"])
def test_knobs_cannot_be_pushed_over_their_threads(solids, links, name):
    push = Pose.from_translation(0, 0, -0.0015)
    pushed = moved(solids[name], links[name].parent_from_child @ push)
    assert (solids[links[name].parent] ^ pushed).volume() > 10


@pytest.mark.parametrize("name", ["thread-1", "thread-2"])
def test_threads_can_neither_be_pulled_up_nor_turned_in_their_slots(solids, links, name):
    place = links[name].parent_from_child
    for motion in (Pose.from_translation(0, 0.002, 0), Pose.exp([0, math.radians(20), 0, 0, 0, 0])):
        assert (solids["jaw-1"] ^ moved(solids[name], place @ motion)).volume() > 10


def test_the_jaws_look_alike_but_can_be_told_apart(solids):
    one, two = solids["jaw-1"], solids["jaw-2"]
    hulls = one.hull(), two.hull()
    assert (hulls[0] - hulls[1]).volume() < 0.03 * hulls[0].volume()
    for other in (two, two.mirror([0, 1, 0])):
        difference = (one - other).volume() + (other - one).volume()
        assert difference > 0.1 * one.volume()


def test_the_manifest_agrees_with_the_dimensions_of_the_script(links):
    expected_mm = {
        "pad": clamp.PAD_ON_JAW_MM,
        "thread-1": clamp.THREADS_IN_JAW_MM[0],
        "thread-2": clamp.THREADS_IN_JAW_MM[1],
        "jaw-2": clamp.JAW_2_ON_JAW_1_MM,
        "knob-1": clamp.KNOB_ON_THREAD_MM,
        "knob-2": clamp.KNOB_ON_THREAD_MM,
    }
    assert links.keys() == expected_mm.keys()
    for name, position_mm in expected_mm.items():
        position = links[name].parent_from_child.translation * 1000
        np.testing.assert_allclose(position, position_mm, atol=1e-9)
    for name in ("knob-1", "knob-2"):
        assert links[name].joint.pitch_m * 1000 == pytest.approx(clamp.THREAD_LEAD_MM)
        assert links[name].joint.travel_m[0] * 1000 == pytest.approx(-clamp.KNOB_ENGAGED_MM)
