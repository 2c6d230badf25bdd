"""The Geared Caliper: its meshes are what the script makes, its parts fit, its gears mesh."""

import itertools
import math

import manifold3d
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import find_asset
from snapfit.models.assets import geared_caliper as caliper
from snapfit.models.assets.solids import ply_bytes
from snapfit.models.assets.solids_plates import filleted, gear_outline, opening, plate, rectangle
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose

EXTENTS_MM = {
    "fix": (207, 5, 110),
    "move-bottom": (90, 110, 17),
    "move-top-vernier": (65, 17, 46),
    "gear-large": (37.89, 37.89, 4.8),
    "gear-small": (13.89, 13.89, 7.1),
    "roller": (21.89, 21.89, 10.1),
}
GEARS = ("gear-large", "gear-small", "roller")
LARGEST_OVERLAP_MM3 = 0.1
HALF_TURNS = [Pose.exp([*(math.pi * np.eye(3)[axis]), 0, 0, 0]) for axis in range(3)]


@pytest.fixture(scope="module")
def solids():
    return caliper.parts()


@pytest.fixture(scope="module")
def asset():
    return find_asset("geared-caliper")


def moved(solid, pose):
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= 1000
    return solid.transform(matrix)


def links(asset):
    return {link.child: link for link in asset.states[-1].links}


def placed(solids, asset):
    there = {
        name: moved(solids[name], link.parent_from_child) for name, link in links(asset).items()
    }
    return there | {"move-bottom": solids["move-bottom"]}


def test_the_meshes_of_the_bundle_are_those_that_the_script_makes(solids, asset):
    assert solids.keys() == {part.name for part in asset.parts} == EXTENTS_MM.keys()
    for part in asset.parts:
        bundled = manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        made = solids[part.name]
        assert (bundled - made).volume() + (made - bundled).volume() < 5e-4 * made.volume()


def test_the_script_makes_the_same_bytes_each_time(solids):
    again = caliper.parts()
    for name, solid in solids.items():
        assert ply_bytes(solid) == ply_bytes(again[name]), name


def test_writing_the_bundle_makes_every_mesh(tmp_path, monkeypatch):
    monkeypatch.setattr(caliper, "DIRECTORY", tmp_path)
    caliper.main()
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.ply" for name in EXTENTS_MM}


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_parts_are_closed_whole_and_of_the_stated_size(asset, solids, name):
    mesh = next(part.mesh for part in asset.parts if part.name == name)
    assert count_open_edges(mesh.faces) == 0
    assert 1000 <= len(mesh.faces) <= 10_000
    assert len(solids[name].decompose()) == 1
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0) * 1000, EXTENTS_MM[name], atol=0.05)


def test_jaws_slide_and_cover_are_tracked_and_the_gears_are_not(asset):
    tracked = {part.name: part.tracked for part in asset.parts}
    assert tracked == {name: name not in GEARS for name in EXTENTS_MM}
    decides = {name: link.decides_switch for name, link in links(asset).items()}
    assert decides == {name: name not in GEARS for name in EXTENTS_MM if name != "move-bottom"}


def test_the_parts_of_the_assembled_caliper_touch_nowhere(solids, asset):
    there = placed(solids, asset)
    for one, other in itertools.combinations(there, 2):
        assert (there[one] ^ there[other]).volume() < LARGEST_OVERLAP_MM3, (one, other)


@pytest.mark.parametrize(
    ("one", "other"), [("gear-large", "roller"), ("gear-large", "gear-small"), ("roller", "fix")]
)
def test_teeth_stand_in_the_gaps_of_the_other_gear(solids, asset, one, other):
    """Turned by half a tooth they would collide."""
    there = placed(solids, asset)
    n_teeth = {"gear-large": 36, "roller": 12 if other == "fix" else 20}[one]
    turned = links(asset)[one].parent_from_child @ Pose.exp([0, 0, math.pi / n_teeth, 0, 0, 0])
    assert (moved(solids[one], turned) ^ there[other]).volume() > 3


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 1.0])
def test_the_beam_slides_freely_between_the_limits_of_its_joint(solids, asset, share):
    link = links(asset)["fix"]
    assert link.joint.type is JointType.PRISMATIC
    low, high = link.joint.travel_m
    travel = Pose.from_translation(low + share * (high - low), 0, 0)
    beam = moved(solids["fix"], link.parent_from_child @ travel)
    there = placed(solids, asset)
    for name in ("move-bottom", "move-top-vernier", "gear-large", "gear-small"):
        assert (beam ^ there[name]).volume() < LARGEST_OVERLAP_MM3, name


def test_the_jaws_touch_at_the_end_of_the_travel(solids, asset):
    link = links(asset)["fix"]
    beyond = Pose.from_translation(link.joint.travel_m[1] + 0.0005, 0, 0)
    closed = moved(solids["fix"], link.parent_from_child @ beyond)
    assert (closed ^ solids["move-bottom"]).volume() > 50


def test_the_cover_holds_the_beam_in_the_channel(solids, asset):
    there = placed(solids, asset)
    lifted = there["fix"].translate([0, 0, 2])
    assert (lifted ^ solids["move-bottom"]).volume() < LARGEST_OVERLAP_MM3
    assert (lifted ^ there["move-top-vernier"]).volume() > 10


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_stated_symmetries_are_true_and_complete(solids, asset, name):
    part = next(part for part in asset.parts if part.name == name)
    whole = solids[name].volume()
    assert part.symmetry.axis is None
    assert len(part.symmetry.motions) == {"gear-large": 5, "roller": 3}.get(name, 0)
    for motion in part.symmetry.motions:
        assert (solids[name] ^ moved(solids[name], motion)).volume() > 0.999 * whole
    for turn in HALF_TURNS:
        stated = any(turn.angle_to(motion) < 1e-6 for motion in part.symmetry.motions)
        common = (solids[name] ^ moved(solids[name], turn)).volume() / whole
        assert stated or common < 0.995, turn


def test_the_manifest_agrees_with_the_dimensions_of_the_script(asset):
    base = np.array(caliper.ORIGIN_MM["move-bottom"])
    turns = caliper.gear_turn_rad()
    for name, link in links(asset).items():
        there = np.array(caliper.ORIGIN_MM[name]) - base
        np.testing.assert_allclose(link.parent_from_child.translation * 1000, there, atol=1e-3)
        turn = [0, 0, turns[name]] if name in turns else [-math.pi / 2, 0, 0]
        assert link.parent_from_child.angle_to(Pose.exp([*turn, 0, 0, 0])) < 1e-5
    np.testing.assert_allclose(
        np.array(links(asset)["fix"].joint.travel_m) * 1000, caliper.FIX_TRAVEL_MM
    )


def test_the_steps_lead_from_loose_parts_to_the_caliper(asset):
    names = ["parts-free", "beam-in-slide", "assembled"]
    assert [state.name for state in asset.states] == names
    assert [len(state.links) for state in asset.states] == [0, 1, 5]
    assert [(step.from_state, step.to_state) for step in asset.steps] == [
        *itertools.pairwise(names)
    ]


def test_annotations_are_anchored_at_their_parts(asset):
    surfaces = {
        part.name: trimesh.Trimesh(part.mesh.vertices, part.mesh.faces) for part in asset.parts
    }
    for step in asset.steps:
        assert step.annotation
        for note in step.annotation:
            _, apart_m, _ = trimesh.proximity.closest_point(surfaces[note.part], [note.anchor_m])
            assert apart_m[0] < 0.006, note.text


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
