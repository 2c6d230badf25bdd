"""The Hobby Corner Clamp: its meshes are what the script makes, and its parts fit together."""

import math

import manifold3d
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.assets import hobby_corner_clamp as clamp
from snapfit.models.assets.solids import ply_bytes, thread
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry

EXTENTS_MM = {"base": (160, 99, 54), "jaw": (85, 64, 53), "bolt": (59, 53, 131)}
LARGEST_OVERLAP_MM3 = 0.1


@pytest.fixture(scope="module")
def solids():
    return clamp.parts()


@pytest.fixture(scope="module")
def asset():
    return find_asset("hobby-corner-clamp")


def in_base(solid, pose):
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= 1000
    return solid.transform(matrix)


def links(asset):
    return {link.child: link for link in asset.states[-1].links}


def test_the_meshes_of_the_bundle_are_those_that_the_script_makes(solids, asset):
    """By shape, not by bytes: another release of manifold3d may number vertices differently."""
    assert solids.keys() == {part.name for part in asset.parts} == EXTENTS_MM.keys()
    for part in asset.parts:
        bundled = manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        made = solids[part.name]
        assert (bundled - made).volume() + (made - bundled).volume() < 5e-4 * made.volume()


def test_the_script_makes_the_same_bytes_each_time(solids):
    again = clamp.parts()
    for name, solid in solids.items():
        assert ply_bytes(solid) == ply_bytes(again[name]), name


def test_writing_the_bundle_makes_every_mesh(tmp_path, monkeypatch):
    monkeypatch.setattr(clamp, "DIRECTORY", tmp_path)
    clamp.main()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["base.ply", "bolt.ply", "jaw.ply"]


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_parts_are_closed_and_of_the_stated_size(asset, name):
    mesh = next(part.mesh for part in asset.parts if part.name == name)
    assert count_open_edges(mesh.faces) == 0
    assert 2500 <= len(mesh.faces) <= 20_000
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0) * 1000, EXTENTS_MM[name], atol=0.05)


def test_the_parts_of_the_assembled_clamp_touch_nowhere(solids, asset):
    placed = {
        name: in_base(solids[name], link.parent_from_child) for name, link in links(asset).items()
    }
    placed["base"] = solids["base"]
    for one, other in (("base", "jaw"), ("base", "bolt"), ("jaw", "bolt")):
        assert (placed[one] ^ placed[other]).volume() < LARGEST_OVERLAP_MM3, (one, other)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
def test_the_jaw_slides_freely_between_the_limits_of_its_joint(solids, asset, share):
    link = links(asset)["jaw"]
    assert link.joint.type is JointType.PRISMATIC
    low, high = link.joint.travel_m
    pose = link.parent_from_child @ Pose.from_translation(low + share * (high - low), 0, 0)
    assert (solids["base"] ^ in_base(solids["jaw"], pose)).volume() < LARGEST_OVERLAP_MM3


def test_the_jaw_can_be_lifted_out_only_at_the_wide_end_of_the_slot(solids, asset):
    link = links(asset)["jaw"]
    for travel_m, is_free in ((link.joint.travel_m[0], True), (0.0, False)):
        lifted = link.parent_from_child @ Pose.from_translation(travel_m, 0, 0.003)
        overlap = (solids["base"] ^ in_base(solids["jaw"], lifted)).volume()
        assert (overlap < LARGEST_OVERLAP_MM3) == is_free


@pytest.mark.parametrize("share", [0.0, 0.37, 0.71])
def test_the_bolt_turns_in_its_thread_and_cannot_be_pushed_through(solids, asset, share):
    link = links(asset)["bolt"]
    travel_m = share * link.joint.travel_m[0]
    turn = 2 * math.pi * travel_m / link.joint.pitch_m
    screwed = link.parent_from_child @ Pose.exp([0, 0, turn, 0, 0, travel_m])
    assert (solids["base"] ^ in_base(solids["bolt"], screwed)).volume() < LARGEST_OVERLAP_MM3
    pushed = screwed @ Pose.from_translation(0, 0, 0.0015)
    assert (solids["base"] ^ in_base(solids["bolt"], pushed)).volume() > 10


def test_the_stated_symmetry_of_the_bolt_is_true(solids, asset):
    bolt = next(part for part in asset.parts if part.name == "bolt")
    assert len(bolt.symmetry.motions) == 2
    whole = solids["bolt"].volume()
    for motion in bolt.symmetry.motions:
        common = (solids["bolt"] ^ in_base(solids["bolt"], motion)).volume()
        assert common > 0.9999 * whole
    half_way = Pose.exp([0, 0, math.pi / 3, 0, 0, 0])
    assert (solids["bolt"] ^ in_base(solids["bolt"], half_way)).volume() < 0.9 * whole
    turned = Pose.exp([0, 0, math.radians(121), 0, 0, 0])
    error_m, error_rad = distance_modulo_symmetry(turned, Pose.identity(), bolt.symmetry)
    assert error_m == pytest.approx(0, abs=1e-9)
    assert math.degrees(error_rad) == pytest.approx(1, abs=1e-6)


def test_the_manifest_agrees_with_the_dimensions_of_the_script(asset):
    jaw, bolt = links(asset)["jaw"], links(asset)["bolt"]
    np.testing.assert_allclose(jaw.parent_from_child.translation * 1000, clamp.JAW_IN_BASE_MM)
    np.testing.assert_allclose(np.array(jaw.joint.travel_m) * 1000, clamp.JAW_TRAVEL_MM)
    np.testing.assert_allclose(bolt.parent_from_child.translation * 1000, clamp.BOLT_IN_BASE_MM)
    assert bolt.joint.pitch_m * 1000 == pytest.approx(clamp.THREAD_LEAD_MM)
    assert bolt.joint.travel_m[0] * 1000 == pytest.approx(-clamp.BOLT_ENGAGED_MM)


def test_the_steps_lead_from_loose_parts_to_the_clamp(asset):
    assert [state.name for state in asset.states] == ["parts-free", "jaw-mounted", "assembled"]
    assert [len(state.links) for state in asset.states] == [0, 1, 2]
    chain = [(step.from_state, step.to_state) for step in asset.steps]
    assert chain == [("parts-free", "jaw-mounted"), ("jaw-mounted", "assembled")]


def test_a_thread_is_a_helix():
    ridge = thread(5.0, 7.0, lead=6.0, starts=2, z=(0.0, 18.0))
    screwed = ridge.rotate([0, 0, 120]).translate([0, 0, 2.0])
    common = (ridge ^ screwed).volume() / ridge.volume()
    only_turned = (ridge ^ ridge.rotate([0, 0, 90])).volume() / ridge.volume()
    assert common > 16 / 18 - 0.01
    assert only_turned < 0.92
