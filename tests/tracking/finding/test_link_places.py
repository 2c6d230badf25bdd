"""Places that links know, on small parts."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Part, find_asset
from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Joint, Link, State
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry, SymmetryAxis, distance_modulo_symmetry
from snapfit.tracking.finding.link_places import LinkPlaces

AT = Pose.exp([0.1, -0.2, 0.3, 0.02, 0.01, 0.05])
Z = np.array([0.0, 0.0, 1.0])
ORIGIN = np.zeros(3)


def part(name: str, symmetry: Symmetry | None = None) -> Part:
    box = trimesh.creation.box(extents=(0.04, 0.05, 0.06))
    mesh = Mesh(np.asarray(box.vertices, np.float32), np.asarray(box.faces, np.int32))
    return Part(name, mesh, symmetry=symmetry or Symmetry())


def places_of(joint: Joint, *symmetries: Symmetry) -> tuple[LinkPlaces, Link]:
    link = Link(parent="base", child="lid", parent_from_child=AT, joint=joint)
    names = ("base", "lid")
    given = symmetries or (Symmetry(), Symmetry())
    parts = [part(name, each) for name, each in zip(names, given, strict=True)]
    states = [State(name="free"), State(name="on", link=(link,)), State(name="more", link=(link,))]
    return LinkPlaces(parts, states), link


def off(
    places: tuple[Pose, ...], pose: Pose, symmetry: Symmetry | None = None
) -> tuple[float, float]:
    """How far the nearest place is off, m and degrees."""
    each = [distance_modulo_symmetry(pose, place, symmetry or Symmetry()) for place in places]
    way_m, turn_rad = min(each, key=lambda it: it[0] + 0.05 * it[1])
    return way_m, math.degrees(turn_rad)


def test_a_fixed_part_has_one_place_seen_from_either_side() -> None:
    places, _ = places_of(Joint())
    (lid,), (base,) = places.beside("base", "lid"), places.beside("lid", "base")
    np.testing.assert_allclose(lid.matrix, AT.matrix)
    np.testing.assert_allclose(base.matrix, AT.inverse().matrix, atol=1e-12)
    assert places.beside("base", "base") == places.beside("base", "roof") == ()


@pytest.mark.parametrize(
    "joint",
    [
        Joint(type="prismatic", axis=(0, 0, 1), travel_m=(-0.055, 0.02)),
        Joint(type="revolute", axis=(0, 0, 1), turn_deg=(-32, 148)),
        Joint(type="revolute", axis=(0, 0, 1)),
        Joint(type="screw", axis=(0, 0, 1), pitch_m=0.02, travel_m=(-0.03, 0.01)),
        Joint(type="cylindrical", axis=(0, 0, 1), turn_deg=(0, 90), travel_m=(0.0, 0.03)),
    ],
    ids=lambda joint: f"{joint.type.value} {joint.turn_deg}",
)
def test_the_whole_range_of_a_joint_is_near_a_place(joint: Joint) -> None:
    places, link = places_of(joint)
    motion = JointMotion.of(link)
    low, high = np.where(np.isfinite(motion.limits), motion.limits, [-math.pi, math.pi]).T
    rng = np.random.default_rng(0)
    for q in (low, high, *rng.uniform(low, high, (50, motion.n_dof))):
        there = motion.parent_from_child(q)
        for pose, found in (
            (there, places.beside("base", "lid")),
            (there.inverse(), places.beside("lid", "base")),
        ):
            way_m, turn_deg = off(found, pose)
            assert way_m < 0.016
            assert turn_deg < 17


def test_a_joint_without_an_end_is_followed_for_a_hand_s_breadth() -> None:
    places, _ = places_of(Joint(type="prismatic", axis=(0, 0, 1)))
    ways = [float((AT.inverse() @ each).translation[2]) for each in places.beside("base", "lid")]
    assert (min(ways), max(ways)) == pytest.approx((-0.05, 0.05))


def test_the_known_part_may_stand_in_any_pose_that_looks_the_same() -> None:
    flip = Pose.exp([0, 0, math.pi, 0, 0, 0])
    places, _ = places_of(Joint(), Symmetry((flip,)), Symmetry())
    assert len(places.beside("base", "lid")) == 2
    assert max(off(places.beside("base", "lid"), flip @ AT)) < 1e-6
    # Of the one that is looked for it is no other place.
    assert len(places.beside("lid", "base")) == 1


def test_turns_about_an_axis_of_symmetry_are_places_of_others_alone() -> None:
    around = Symmetry((), SymmetryAxis(Z, ORIGIN))
    places, _ = places_of(Joint(), around, Symmetry())
    for angle in np.linspace(0, 2 * math.pi, 40):
        way_m, turn_deg = off(places.beside("base", "lid"), around.axis.turn(angle) @ AT)
        assert way_m < 0.006
        assert turn_deg < 11
    assert len(places.beside("lid", "base")) == 1


def test_places_beside_known_parts_are_in_the_camera_s_frame() -> None:
    places, _ = places_of(Joint())
    here = Pose.exp([0.3, 0.1, 0.0, 0.0, 0.0, 0.5])
    (pose,) = places.of("lid", {"base": here, "roof": Pose.identity()})
    np.testing.assert_allclose(pose.matrix, (here @ AT).matrix)
    assert places.of("lid", {}) == []


@pytest.mark.parametrize("name", ["nano-chuck", "liftpod", "hand-screw-clamp", "geared-caliper"])
def test_every_link_of_the_bundled_assets_has_its_place(name: str) -> None:
    asset = find_asset(name)
    tracked = {part.name: part for part in asset.tracked_parts}
    places = LinkPlaces(asset.tracked_parts, asset.states)
    links = [link for state in asset.states for link in state.links]
    for link in links:
        if link.parent not in tracked or link.child not in tracked:
            assert places.beside(link.parent, link.child) == ()
            continue
        symmetry = tracked[link.child].symmetry
        way_m, turn_deg = off(
            places.beside(link.parent, link.child), link.parent_from_child, symmetry
        )
        assert way_m < 0.004
        assert turn_deg < 8
