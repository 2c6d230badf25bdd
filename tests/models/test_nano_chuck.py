"""The Nano Chuck: its meshes are what the script makes, its parts fit, its symmetries are true."""

import math

import manifold3d
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import find_asset
from snapfit.models.assets import nano_chuck as chuck
from snapfit.models.assets import nano_chuck_vise as vise
from snapfit.models.assets.solids import ply_bytes
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose

EXTENTS_MM = {
    "base": (165, 82, 40),
    "screw": (58, 58, 131),
    "headplate": (44, 44, 16),
    "balljoint": (36, 36, 57),
    "nut": (59, 59, 25),
    "vise-base": (80, 108, 77),
    "vise-slider": (80, 47, 26),
    "vise-screw": (34, 34, 104),
}
SYMMETRIC = {"screw": 3, "headplate": 3, "nut": 7, "balljoint": "axis", "vise-screw": "axis"}
FRAME_PARTS = {"balljoint", "vise-base", "vise-slider"}
LARGEST_OVERLAP_MM3 = 0.1
LARGEST_DEVIATION_MM = 0.3
THREAD_DEPTH_MM = {"balljoint": 1.1, "vise-screw": 0.9}


@pytest.fixture(scope="module")
def solids():
    return chuck.parts()


@pytest.fixture(scope="module")
def asset():
    return find_asset("nano-chuck")


@pytest.fixture(scope="module")
def links(asset):
    return {link.child: link for link in asset.states[-1].links}


def moved(solid, pose):
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= 1000
    return solid.transform(matrix)


def base_from(name, links):
    if name not in links:
        return Pose.identity()
    return base_from(links[name].parent, links) @ links[name].parent_from_child


def along(joint, share):
    """`child_from_child` at a share of the joint's travel, screws turning as they go."""
    low, high = joint.travel_m
    travel_m = low + share * (high - low)
    axis = np.array(joint.axis)
    turn = 2 * math.pi * travel_m / joint.pitch_m if joint.type is JointType.SCREW else 0.0
    return Pose.exp([*(turn * axis), *(travel_m * axis)])


def deviation_mm(part, motion):
    """The farthest that a point of the moved surface lies from the surface."""
    mesh = trimesh.Trimesh(part.mesh.vertices * 1000.0, part.mesh.faces, process=False)
    points, _ = trimesh.sample.sample_surface(mesh, 1500, seed=3)
    points = motion.transform(points / 1000) * 1000
    _, distances, _ = trimesh.proximity.closest_point(mesh, points)
    return float(distances.max())


def test_the_meshes_of_the_bundle_are_those_that_the_script_makes(solids, asset):
    assert solids.keys() == {part.name for part in asset.parts} == EXTENTS_MM.keys()
    for part in asset.parts:
        bundled = manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        made = solids[part.name]
        assert (bundled - made).volume() + (made - bundled).volume() < 1e-3 * made.volume()


def test_the_script_makes_the_same_bytes_each_time(solids):
    again = chuck.parts()
    for name, solid in solids.items():
        assert ply_bytes(solid) == ply_bytes(again[name]), name


def test_writing_the_bundle_makes_every_mesh(tmp_path, monkeypatch):
    monkeypatch.setattr(chuck, "DIRECTORY", tmp_path)
    chuck.main()
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.ply" for name in EXTENTS_MM}


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_parts_are_closed_in_one_piece_and_of_the_stated_size(solids, asset, name):
    mesh = next(part.mesh for part in asset.parts if part.name == name)
    assert count_open_edges(mesh.faces) == 0
    assert len(solids[name].decompose()) == 1
    assert 1000 <= len(mesh.faces) <= 10_000
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0) * 1000, EXTENTS_MM[name], atol=0.05)


def test_the_parts_of_the_assembled_chuck_touch_nowhere(solids, links):
    placed = [(name, moved(solid, base_from(name, links))) for name, solid in solids.items()]
    for i, (one, solid) in enumerate(placed):
        for other, second in placed[i + 1 :]:
            assert (solid ^ second).volume() < LARGEST_OVERLAP_MM3, (one, other)


@pytest.mark.parametrize("share", [0.0, 0.29, 0.63, 1.0])
@pytest.mark.parametrize("name", ["screw", "nut", "vise-base", "vise-slider", "vise-screw"])
def test_parts_move_freely_between_the_limits_of_their_joints(solids, links, name, share):
    link = links[name]
    pose = link.parent_from_child @ along(link.joint, share)
    overlap = (solids[link.parent] ^ moved(solids[name], pose)).volume()
    assert overlap < LARGEST_OVERLAP_MM3


@pytest.mark.parametrize("name", ["screw", "nut", "vise-base", "vise-screw"])
def test_screws_cannot_be_pushed_through_their_threads(solids, links, name):
    link = links[name]
    push = Pose.from_translation(*(-0.0015 * np.array(link.joint.axis)))
    pushed = moved(solids[name], link.parent_from_child @ push)
    assert (solids[link.parent] ^ pushed).volume() > 10


@pytest.mark.parametrize("turn_deg", [17.0, 45.0, 90.0])
def test_the_headplate_swivels_on_the_tip_and_cannot_be_pulled_off(solids, links, turn_deg):
    link = links["headplate"]
    assert link.joint.type is JointType.REVOLUTE
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


@pytest.mark.parametrize("name", SYMMETRIC)
def test_the_stated_symmetries_are_true(asset, name):
    part = next(part for part in asset.parts if part.name == name)
    symmetry = part.symmetry
    if SYMMETRIC[name] == "axis":
        assert symmetry.axis is not None
        assert not symmetry.motions
        for angle_deg in (40, 101, 180, 233):
            turn = symmetry.axis.turn(math.radians(angle_deg))
            assert deviation_mm(part, turn) < THREAD_DEPTH_MM[name] + 0.1
    else:
        assert symmetry.axis is None
        assert len(symmetry.motions) == SYMMETRIC[name]
        for motion in symmetry.motions:
            assert deviation_mm(part, motion) < LARGEST_DEVIATION_MM
        between = Pose.exp([0, 0, math.pi / (SYMMETRIC[name] + 1), 0, 0, 0])
        assert deviation_mm(part, between) > 4 * LARGEST_DEVIATION_MM


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_no_other_half_turn_maps_a_part_onto_itself(asset, name):
    part = next(part for part in asset.parts if part.name == name)
    # Of a symmetric part, the axis z is that of its symmetry.
    axes = np.eye(3)[: 2 if name in SYMMETRIC else 3]
    assert part.symmetry.is_none == (name not in SYMMETRIC)
    for axis in axes:
        assert deviation_mm(part, Pose.exp([*(math.pi * axis), 0, 0, 0])) > 2.5


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


def test_each_step_adds_one_part_whose_link_decides_and_screws_decide_no_more_after(asset):
    states = {state.name: state for state in asset.states}
    assert [len(state.links) for state in asset.states] == list(range(8))
    assert [step.from_state for step in asset.steps] == [s.name for s in asset.states[:-1]]
    assert [step.to_state for step in asset.steps] == [s.name for s in asset.states[1:]]
    for step in asset.steps:
        before = {link.child for link in states[step.from_state].links}
        for link in states[step.to_state].links:
            is_new = link.child not in before
            assert link.decides_switch == (is_new or link.child in FRAME_PARTS)
            if is_new:
                assert step.ghost.part == link.child
                assert step.ghost.parent == link.parent
                assert step.ghost.parent_from_part.distance_to(link.parent_from_child) < 1e-9
                assert step.ghost.parent_from_part.angle_to(link.parent_from_child) < 1e-6
        assert step.annotation
        assert {note.part for note in step.annotation} <= set(step.parts)


def test_annotations_point_at_their_parts(asset):
    meshes = {part.name: part.mesh for part in asset.parts}
    for step in asset.steps:
        for note in step.annotation:
            lower, upper = meshes[note.part].vertices.min(0), meshes[note.part].vertices.max(0)
            assert (np.array(note.anchor_m) >= lower - 1e-4).all(), note
            assert (np.array(note.anchor_m) <= upper + 1e-4).all(), note
