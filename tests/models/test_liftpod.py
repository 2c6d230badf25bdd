"""The LiftPod: its meshes are what the script makes, its hinges turn, its symmetries are true."""

import itertools
import math

import manifold3d
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import find_asset
from snapfit.models.assets import liftpod
from snapfit.models.assets.solids import ply_bytes
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose

EXTENTS_MM = {
    "arm-first": (115, 20, 8),
    "arm-last": (140, 20, 8),
    "bar": (143, 15, 11),
    "base-plate": (124, 90, 26),
    "clamp-frame": (70, 80, 20),
    "clamp-slider": (52, 46, 20),
    "sleeve": (20, 20, 72),
}
# Axes (of the body frame) about which half a turn maps the part onto itself.
HALF_TURNS = {"arm-first": "xyz", "arm-last": "xyz", "bar": "xyz", "base-plate": "z"}
HALF_TURNS |= {"clamp-frame": "", "clamp-slider": "", "sleeve": "xyz"}
LARGEST_OVERLAP_MM3 = 0.1
LARGEST_MISFIT_MM = 0.3


@pytest.fixture(scope="module")
def solids():
    return liftpod.parts()


@pytest.fixture(scope="module")
def asset():
    return find_asset("liftpod")


def moved(solid, pose):
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= 1000
    return solid.transform(matrix)


def state(asset, name="assembled"):
    return next(state for state in asset.states if state.name == name)


def links(asset, name="assembled"):
    return {link.child: link for link in state(asset, name).links}


def half_turn(axis):
    return Pose.exp([*(math.pi * np.eye(3)["xyz".index(axis)]), 0, 0, 0])


def along_joint(joint, value):
    """`child_from_child` at a travel (m) or a turn (deg) of the joint."""
    axis = np.array(joint.axis)
    if joint.type is JointType.PRISMATIC:
        return Pose.from_translation(*(value * axis))
    turn = Pose.exp([*(math.radians(value) * axis), 0, 0, 0])
    point = np.array(joint.point_m)
    return Pose.from_rotation_translation(turn.rotation, point - turn.rotation @ point)


def limits(joint):
    return joint.travel_m if joint.type is JointType.PRISMATIC else joint.turn_deg


def test_the_meshes_of_the_bundle_are_those_that_the_script_makes(solids, asset):
    assert solids.keys() == {part.name for part in asset.parts} == EXTENTS_MM.keys()
    for part in asset.parts:
        bundled = manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        made = solids[part.name]
        assert (bundled - made).volume() + (made - bundled).volume() < 5e-4 * made.volume()


def test_the_script_makes_the_same_bytes_each_time(solids):
    again = liftpod.parts()
    for name, solid in solids.items():
        assert ply_bytes(solid) == ply_bytes(again[name]), name


def test_writing_the_bundle_makes_every_mesh(tmp_path, monkeypatch):
    monkeypatch.setattr(liftpod, "DIRECTORY", tmp_path)
    liftpod.main()
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.ply" for name in EXTENTS_MM}


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_parts_are_closed_whole_and_of_the_stated_size(asset, solids, name):
    part = next(part for part in asset.parts if part.name == name)
    assert part.tracked
    assert count_open_edges(part.mesh.faces) == 0
    assert 1000 <= len(part.mesh.faces) <= 10_000
    assert len(solids[name].decompose()) == 1
    extents = np.ptp(part.mesh.vertices, axis=0) * 1000
    np.testing.assert_allclose(extents, EXTENTS_MM[name], atol=0.05)


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_stated_symmetries_map_the_part_onto_itself(asset, name):
    part = next(part for part in asset.parts if part.name == name)
    assert part.symmetry.axis is None
    stated = [half_turn(axis) for axis in HALF_TURNS[name]]
    assert len(part.symmetry.motions) == len(stated)
    mesh = trimesh.Trimesh(part.mesh.vertices * 1000, part.mesh.faces, process=False)
    points = np.vstack([mesh.vertices, mesh.triangles_center])
    for motion, expected in zip(part.symmetry.motions, stated, strict=True):
        assert motion.angle_to(expected) < 1e-6
        turned = motion.transform(points / 1000) * 1000
        _, misfit, _ = trimesh.proximity.closest_point(mesh, turned)
        assert misfit.max() < LARGEST_MISFIT_MM


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_no_other_half_turn_and_no_quarter_turn_does(solids, name):
    whole = solids[name].volume()
    for axis in "xyz":
        quarter = Pose.exp([*(math.pi / 2 * np.eye(3)["xyz".index(axis)]), 0, 0, 0])
        assert (solids[name] ^ moved(solids[name], quarter)).volume() < 0.97 * whole, axis
        if axis not in HALF_TURNS[name]:
            turned = moved(solids[name], half_turn(axis))
            assert (solids[name] ^ turned).volume() < 0.97 * whole, axis


def test_the_parts_of_the_assembled_stand_touch_nowhere(solids, asset):
    there = {"base-plate": (solids["base-plate"], Pose.identity())}
    for link in state(asset).links:
        pose = there[link.parent][1] @ link.parent_from_child
        there[link.child] = (moved(solids[link.child], pose), pose)
    assert there.keys() == EXTENTS_MM.keys()
    for one, other in itertools.combinations(there, 2):
        overlap = (there[one][0] ^ there[other][0]).volume()
        assert overlap < LARGEST_OVERLAP_MM3, (one, other)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("child", [name for name in EXTENTS_MM if name != "base-plate"])
def test_joints_move_freely_between_their_limits(solids, asset, child, share):
    for name in ("sleeve-on-bar", "assembled"):
        link = links(asset, name).get(child)
        if link is None:
            continue
        low, high = limits(link.joint)
        pose = link.parent_from_child @ along_joint(link.joint, low + share * (high - low))
        overlap = (solids[link.parent] ^ moved(solids[child], pose)).volume()
        assert overlap < LARGEST_OVERLAP_MM3, (name, overlap)


@pytest.mark.parametrize("child", ["arm-first", "arm-last", "bar", "clamp-frame"])
def test_the_pins_hold_what_is_hinged(solids, asset, child):
    """Pulled away from the hinge by 2 mm, a pin meets its fork."""
    link = links(asset)[child]
    assert link.joint.type is JointType.REVOLUTE
    away = -np.array(link.joint.point_m)
    pulled = link.parent_from_child @ Pose.from_translation(*(0.002 * away / np.linalg.norm(away)))
    assert (solids[link.parent] ^ moved(solids[child], pulled)).volume() > 5


def test_the_sleeve_comes_off_only_before_the_clamp_is_mounted(asset):
    before, after = links(asset, "sleeve-on-bar")["sleeve"], links(asset)["sleeve"]
    bar_end_m, half_sleeve_m = 0.0715, 0.036
    off_m = before.parent_from_child.translation[0] - before.joint.travel_m[0]
    assert off_m - half_sleeve_m > bar_end_m
    assert after.joint.travel_m[0] > before.joint.travel_m[0]


def test_the_rails_hold_the_slider(solids, asset):
    link = links(asset)["clamp-slider"]
    for away in ((0, 0, 0.002), (0.002, 0, 0)):
        pulled = link.parent_from_child @ Pose.from_translation(*away)
        overlap = (solids["clamp-frame"] ^ moved(solids["clamp-slider"], pulled)).volume()
        assert overlap > 10, away


def test_the_manifest_agrees_with_the_dimensions_of_the_script(asset):
    stated, made = links(asset), liftpod.assembled()
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
        travel = np.array(links(asset, name)[child].joint.travel_m) * 1000
        np.testing.assert_allclose(travel, travel_mm)


def test_each_step_adds_one_part(asset):
    assert [len(state.links) for state in asset.states] == list(range(7))
    names = [state.name for state in asset.states]
    assert [(step.from_state, step.to_state) for step in asset.steps] == [
        *itertools.pairwise(names)
    ]
    for step in asset.steps:
        added = links(asset, step.to_state).keys() - links(asset, step.from_state).keys()
        assert added == {step.ghost.part}
        assert step.ghost.part in step.parts


def test_annotations_are_anchored_at_their_parts(asset):
    surfaces = {
        part.name: trimesh.Trimesh(part.mesh.vertices, part.mesh.faces) for part in asset.parts
    }
    for step in asset.steps:
        assert step.annotation
        for note in step.annotation:
            _, apart_m, _ = trimesh.proximity.closest_point(surfaces[note.part], [note.anchor_m])
            assert apart_m[0] < 0.006, note.text
