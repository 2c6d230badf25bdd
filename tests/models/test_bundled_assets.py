"""What every bundled asset keeps: sizes, symmetries, parts that fit, steps that add up."""

import itertools
import math

import manifold3d
import numpy as np
import pytest
import trimesh
from bundled_assets import KEPT, LARGEST_OVERLAP_MM3, along, load_bundle, moved, turned
from scipy.spatial import KDTree

from snapfit.models.asset import bundled_names
from snapfit.models.assets.solids import ply_bytes
from snapfit.models.manifest import JointType
from snapfit.models.mesh import count_open_edges

LARGEST_DEVIATION_MM = 0.3
NEGLIGIBLE_MM = 0.05
# Also where neighbouring teeth, threads and pins stand otherwise than at the ends.
SHARES = (0.0, 0.2, 0.29, 0.3, 0.37, 0.5, 0.63, 0.7, 0.71, 0.8, 1.0)
EVERY = pytest.mark.parametrize("name", KEPT)
EVERY_PART = pytest.mark.parametrize(
    ("name", "part"), [(name, part) for name, kept in KEPT.items() for part in kept.extents_mm]
)
EVERY_JOINT = pytest.mark.parametrize(
    ("name", "child"),
    [
        (name, child)
        for name, kept in KEPT.items()
        for child, joint in kept.joints.items()
        if joint != "fixed" and child not in kept.untracked
    ],
)


def surface(part):
    return trimesh.Trimesh(part.mesh.vertices * 1000.0, part.mesh.faces, process=False)


def samples_mm(mesh):
    return trimesh.sample.sample_surface(mesh, 1500, seed=3)[0]


def deviation_mm(mesh, motion, points_mm):
    """The farthest that a moved point of the surface lies from the surface.

    The distance from the nearest vertex or centre of a triangle is never smaller: what it leaves
    no doubt about is not computed.
    """
    points = motion.transform(points_mm / 1000) * 1000
    bounds = KDTree(np.vstack([mesh.vertices, mesh.triangles_center])).query(points)[0]
    order = np.argsort(-bounds)
    farthest = NEGLIGIBLE_MM
    for first in range(0, len(order), 100):
        chunk = order[first : first + 100]
        if bounds[chunk[0]] <= farthest:
            break
        apart = trimesh.proximity.closest_point(mesh, points[chunk])[1]
        farthest = max(farthest, float(apart.max()))
    return farthest


def common(solid, motion):
    """The share of the volume that a solid has in common with itself moved."""
    return (solid ^ moved(solid, motion)).volume() / solid.volume()


def stated_turns(kept, part):
    axes, fold = kept.turns.get(part, ("", 1))
    return [turned(axis, 2 * math.pi * k / fold) for axis in axes for k in range(1, fold)]


def other_turns(kept, part):
    """Half turns, quarter turns, and half the least turn of the symmetry, unless stated."""
    axes, fold = kept.turns.get(part, ("", 1))
    turns = [(axis, angle) for axis in "xyz" for angle in (math.pi, math.pi / 2)]
    turns += [(axis, math.pi / fold) for axis in axes]
    stated = stated_turns(kept, part)
    for axis, angle in turns:
        turn = turned(axis, angle)
        is_round = part in kept.round_to_mm and axis == "z"
        if not is_round and all(turn.angle_to(motion) > 1e-6 for motion in stated):
            yield turn


def test_every_bundled_asset_stands_in_the_table():
    assert sorted(bundled_names()) == sorted(KEPT)


@EVERY
def test_the_meshes_of_the_bundle_are_those_that_the_script_makes(name):
    """By shape, not by bytes: another release of manifold3d may number vertices differently."""
    bundle, kept = load_bundle(name), KEPT[name]
    assert bundle.parts.keys() == kept.extents_mm.keys()
    assert bundle.meshes.keys() == {kept.meshes.get(part, part) for part in kept.extents_mm}
    for part in bundle.asset.parts:
        bundled = manifold3d.Manifold(
            manifold3d.Mesh(part.mesh.vertices * 1000, part.mesh.faces.astype(np.uint32))
        )
        made = bundle.solids[part.name]
        differing = (bundled - made).volume() + (made - bundled).volume()
        assert differing < kept.misfit * made.volume(), part.name


@EVERY
def test_the_script_makes_the_same_bytes_each_time(name):
    bundle = load_bundle(name)
    again = bundle.script.parts()
    for mesh, solid in bundle.meshes.items():
        assert ply_bytes(solid) == ply_bytes(again[mesh]), mesh


@EVERY
def test_writing_the_bundle_makes_every_mesh(name, tmp_path, monkeypatch):
    script, kept = load_bundle(name).script, KEPT[name]
    monkeypatch.setattr(script, "DIRECTORY", tmp_path)
    script.main()
    expected = {f"{kept.meshes.get(part, part)}.ply" for part in kept.extents_mm}
    assert {path.name for path in tmp_path.iterdir()} == expected


@EVERY_PART
def test_parts_are_closed_in_one_piece_and_of_the_stated_size(name, part):
    bundle, kept = load_bundle(name), KEPT[name]
    mesh = bundle.parts[part].mesh
    assert bundle.parts[part].tracked == (part not in kept.untracked)
    assert count_open_edges(mesh.faces) == 0
    assert kept.n_faces[0] <= len(mesh.faces) <= kept.n_faces[1]
    assert len(bundle.solids[part].decompose()) == 1
    extents_mm = np.ptp(mesh.vertices, axis=0) * 1000
    np.testing.assert_allclose(extents_mm, kept.extents_mm[part], atol=0.05)


@EVERY_PART
def test_stated_symmetries_map_the_part_onto_itself(name, part):
    bundle, kept = load_bundle(name), KEPT[name]
    symmetry, mesh = bundle.parts[part].symmetry, surface(bundle.parts[part])
    points_mm = np.vstack([samples_mm(mesh), mesh.vertices, mesh.triangles_center])
    assert symmetry.is_none == (part not in kept.turns and part not in kept.round_to_mm)
    assert (symmetry.axis is not None) == (part in kept.round_to_mm)
    for motion, expected in zip(symmetry.motions, stated_turns(kept, part), strict=True):
        assert motion.angle_to(expected) < 1e-6
        assert deviation_mm(mesh, motion, points_mm) < LARGEST_DEVIATION_MM
        assert common(bundle.solids[part], motion) > kept.least_common
    if symmetry.axis is not None:
        for angle_deg in (40, 101, 180, 233):
            turn = symmetry.axis.turn(math.radians(angle_deg))
            assert deviation_mm(mesh, turn, samples_mm(mesh)) < kept.round_to_mm[part]


@EVERY_PART
def test_no_other_half_or_quarter_turn_does(name, part):
    bundle, kept = load_bundle(name), KEPT[name]
    mesh = surface(bundle.parts[part])
    points_mm = samples_mm(mesh)
    others = [*other_turns(kept, part)]
    assert others
    for turn in others:
        assert common(bundle.solids[part], turn) < kept.most_common
        assert deviation_mm(mesh, turn, points_mm) > kept.least_deviation_mm


@EVERY
def test_the_parts_of_the_assembled_product_touch_nowhere(name):
    bundle, kept = load_bundle(name), KEPT[name]
    assert bundle.links().keys() == kept.extents_mm.keys() - {kept.base}
    placed = bundle.placed()
    for one, other in itertools.combinations(placed, 2):
        assert (placed[one] ^ placed[other]).volume() < LARGEST_OVERLAP_MM3, (one, other)


@EVERY
def test_joints_are_of_the_stated_types(name):
    kept = KEPT[name]
    found = {child: link.joint.type for child, link in load_bundle(name).links().items()}
    assert found == {child: JointType(joint) for child, joint in kept.joints.items()}


@EVERY_JOINT
def test_parts_move_freely_between_the_limits_of_their_joints(name, child):
    bundle = load_bundle(name)
    links = {
        state.name: bundle.links(state.name)[child]
        for state in bundle.asset.states
        if child in bundle.links(state.name)
    }
    for (state, link), share in itertools.product(links.items(), SHARES):
        pose = link.parent_from_child @ along(link.joint, share)
        overlap = (bundle.solids[link.parent] ^ moved(bundle.solids[child], pose)).volume()
        assert overlap < LARGEST_OVERLAP_MM3, (state, share)


@EVERY
def test_steps_lead_from_state_to_state(name):
    asset, kept = load_bundle(name).asset, KEPT[name]
    names = tuple(state.name for state in asset.states)
    assert kept.states in (None, names)
    assert tuple(len(state.links) for state in asset.states) == kept.n_links
    chain = [(step.from_state, step.to_state) for step in asset.steps]
    assert chain == [*itertools.pairwise(names)]


@EVERY
def test_each_step_adds_what_its_ghost_shows_and_is_judged_by_it(name):
    bundle, kept = load_bundle(name), KEPT[name]
    for step in bundle.asset.steps:
        before, after = bundle.links(step.from_state), bundle.links(step.to_state)
        added = after.keys() - before.keys()
        assert before.keys() <= after.keys()
        assert step.ghost.part in added
        assert added <= set(step.parts)
        target = after[step.ghost.part]
        assert step.ghost.parent == target.parent
        assert step.ghost.parent_from_part.distance_to(target.parent_from_child) < 1e-9
        assert step.ghost.parent_from_part.angle_to(target.parent_from_child) < 1e-6
        for child, link in after.items():
            decides = child not in kept.untracked and (child in added or child in kept.frame)
            assert link.decides_switch == decides, (step.name, child)


@EVERY
def test_annotations_point_at_their_parts(name):
    bundle, kept = load_bundle(name), KEPT[name]
    for step in bundle.asset.steps:
        assert step.annotation
        assert {note.part for note in step.annotation} <= {*step.parts, *kept.noted_beside}
        for note in step.annotation:
            mesh, anchor_mm = surface(bundle.parts[note.part]), 1000 * np.array(note.anchor_m)
            assert (anchor_mm >= mesh.bounds[0] - 0.1).all(), note
            assert (anchor_mm <= mesh.bounds[1] + 0.1).all(), note
            apart_mm = trimesh.proximity.closest_point(mesh, [anchor_mm])[1][0]
            assert apart_mm < kept.note_within_mm, note.text
