"""The Hand-Screw Clamp: its meshes are those of the script, its parts fit, its symmetries hold."""

import math

import manifold3d
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import find_asset
from snapfit.models.assets import hand_screw_clamp as clamp
from snapfit.models.assets.solids import ply_bytes
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose

EXTENTS_MM = {
    "jaw-1": (182, 38, 61),
    "jaw-2": (182, 38, 61),
    "knob-1": (59, 59, 41),
    "knob-2": (59, 59, 41),
    "pad": (51, 51, 45),
    "thread-1": (31, 178, 15),
    "thread-2": (31, 178, 15),
}
# Symmetric parts: how many motions, and the axis of their turns.
SYMMETRIC = {"knob-1": (3, 2), "knob-2": (3, 2), "thread-1": (1, 1), "thread-2": (1, 1)}
FRAME_PARTS = {"pad", "jaw-2"}
LARGEST_OVERLAP_MM3 = 0.1
LARGEST_DEVIATION_MM = 0.3


@pytest.fixture(scope="module")
def meshes():
    """The script's meshes; knob and thread are used twice."""
    return clamp.parts()


@pytest.fixture(scope="module")
def solids(meshes):
    return {name: meshes[name if name in meshes else name[:-2]] for name in EXTENTS_MM}


@pytest.fixture(scope="module")
def asset():
    return find_asset("hand-screw-clamp")


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


def test_the_script_makes_the_same_bytes_each_time(meshes):
    again = clamp.parts()
    for name, solid in meshes.items():
        assert ply_bytes(solid) == ply_bytes(again[name]), name


def test_writing_the_bundle_makes_every_mesh(meshes, tmp_path, monkeypatch):
    monkeypatch.setattr(clamp, "DIRECTORY", tmp_path)
    clamp.main()
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.ply" for name in meshes}


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_parts_are_closed_in_one_piece_and_of_the_stated_size(solids, asset, name):
    mesh = next(part.mesh for part in asset.parts if part.name == name)
    assert count_open_edges(mesh.faces) == 0
    assert len(solids[name].decompose()) == 1
    assert 1000 <= len(mesh.faces) <= 10_000
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0) * 1000, EXTENTS_MM[name], atol=0.05)


def test_the_parts_of_the_assembled_clamp_touch_nowhere(solids, links):
    placed = [(name, moved(solid, base_from(name, links))) for name, solid in solids.items()]
    for i, (one, solid) in enumerate(placed):
        for other, second in placed[i + 1 :]:
            assert (solid ^ second).volume() < LARGEST_OVERLAP_MM3, (one, other)


@pytest.mark.parametrize("share", [0.0, 0.29, 0.63, 1.0])
@pytest.mark.parametrize("name", ["thread-1", "thread-2", "jaw-2", "knob-1", "knob-2"])
def test_parts_move_freely_between_the_limits_of_their_joints(solids, links, name, share):
    link = links[name]
    pose = link.parent_from_child @ along(link.joint, share)
    overlap = (solids[link.parent] ^ moved(solids[name], pose)).volume()
    assert overlap < LARGEST_OVERLAP_MM3


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


@pytest.mark.parametrize("name", SYMMETRIC)
def test_the_stated_symmetries_are_true(asset, name):
    part = next(part for part in asset.parts if part.name == name)
    n_motions, axis = SYMMETRIC[name]
    assert part.symmetry.axis is None
    assert len(part.symmetry.motions) == n_motions
    for motion in part.symmetry.motions:
        assert deviation_mm(part, motion) < LARGEST_DEVIATION_MM
    turn = np.eye(3)[axis] * math.pi / (n_motions + 1)
    assert deviation_mm(part, Pose.exp([*turn, 0, 0, 0])) > 4 * LARGEST_DEVIATION_MM


@pytest.mark.parametrize("name", EXTENTS_MM)
def test_no_other_half_turn_maps_a_part_onto_itself(asset, name):
    part = next(part for part in asset.parts if part.name == name)
    assert part.symmetry.is_none == (name not in SYMMETRIC)
    own = SYMMETRIC.get(name, (0, None))[1]
    for axis in range(3):
        if axis != own:
            half_turn = Pose.exp([*(math.pi * np.eye(3)[axis]), 0, 0, 0])
            assert deviation_mm(part, half_turn) > 2.5


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


def test_each_step_adds_one_part_whose_link_decides_and_screws_decide_no_more_after(asset):
    states = {state.name: state for state in asset.states}
    assert [len(state.links) for state in asset.states] == list(range(7))
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
