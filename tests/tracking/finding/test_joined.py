"""Joined parts on a drawn bench: found where a link puts them, and only where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bench import ASSET, on_bench

from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.joined import JoinedFinder, with_links
from snapfit.tracking.finding.neighbour_search import NeighbourSearch

pytestmark = pytest.mark.usefixtures("needs_open3d")
LINKS = {link.child: link for link in ASSET.states[-1].links}


class Blind:
    """A finder that finds what it is told."""

    names = ("base", "jaw", "bolt")

    def __init__(self, *found: Hypothesis) -> None:
        self.found, self.rejected = list(found), {"low_score": 3}
        self.asked = []

    def find(self, frame, wanted, known=None):
        self.asked.append((frame.name, tuple(wanted), dict(known or {})))
        return [each for each in self.found if each.part in wanted]


@pytest.fixture(scope="module")
def assembled(clamp):
    """Poses of the whole clamp, put together, on the bench."""
    base, *_ = clamp
    there = on_bench(base, [1.2, 0.1, 0.3], -0.02, 0.03)
    return {"base": there} | {
        name: there @ LINKS[name].parent_from_child for name in ("jaw", "bolt")
    }


@pytest.fixture(scope="module")
def search(needs_open3d, bodies, camera):
    del needs_open3d
    return NeighbourSearch(bodies, camera, ASSET)


@pytest.fixture
def finder_of(search):
    return lambda *found: JoinedFinder(Blind(*found), search)


def assert_found(clamp, hypothesis, pose) -> None:
    symmetry = next(part.symmetry for part in clamp if part.name == hypothesis.part)
    off_m, off_rad = distance_modulo_symmetry(hypothesis.camera_from_body, pose, symmetry)
    assert off_m < 0.005, hypothesis.part
    assert np.degrees(off_rad) < 10, hypothesis.part
    assert hypothesis.is_refined
    assert 0.75 <= hypothesis.score <= 1


def test_a_joined_part_is_found_beside_a_known_one(finder_of, clamp, assembled, draw) -> None:
    frame = draw(clamp, assembled)
    known = {"base": assembled["base"], "bolt": assembled["bolt"]}
    (jaw,) = finder_of().find(frame, ["jaw"], known)
    assert jaw.part == "jaw"
    assert_found(clamp, jaw, assembled["jaw"])


def test_what_is_found_carries_the_next(finder_of, clamp, assembled, draw) -> None:
    frame = draw(clamp, assembled)
    # The base is not known, but the other finder finds it in this look.
    seen = Hypothesis("base", assembled["base"], 0.9, is_refined=True)
    found = {each.part: each for each in finder_of(seen).find(frame, ["base", "jaw", "bolt"])}
    assert found["base"] is seen
    assert set(found) == {"base", "jaw", "bolt"}
    for name in ("jaw", "bolt"):
        assert_found(clamp, found[name], assembled[name])


def test_an_empty_place_has_no_part(finder_of, clamp, assembled, lying, draw) -> None:
    alone = {"base": assembled["base"]}
    assert finder_of().find(draw(clamp, alone), ["jaw", "bolt"], alone) == []
    apart = {**lying, "base": assembled["base"], "jaw": lying["jaw"]}
    assert finder_of().find(draw(clamp, apart), ["jaw"], alone) == []


def test_a_part_half_way_to_its_place_is_not_in_it(finder_of, clamp, assembled, draw) -> None:
    above = assembled["jaw"].translation + np.array([0.0, -0.025, -0.025])
    lifted = type(assembled["jaw"]).from_rotation_translation(assembled["jaw"].rotation, above)
    frame = draw(clamp, {"base": assembled["base"], "jaw": lifted})
    assert finder_of().find(frame, ["jaw"], {"base": assembled["base"]}) == []


def test_what_something_hides_is_not_told(finder_of, clamp, assembled, draw) -> None:
    frame = draw(clamp, assembled)
    # A hand, 5 cm before everything.
    assert frame.depth is not None
    depth = np.where(frame.depth > 50, frame.depth - 50, 0).astype(np.uint16)
    known = {"base": assembled["base"], "bolt": assembled["bolt"]}
    assert finder_of().find(replace(frame, depth=depth), ["jaw"], known) == []


def test_parts_that_are_known_cost_no_look(finder_of, clamp, assembled, draw) -> None:
    finder = finder_of()
    frame = draw(clamp, assembled)
    assert finder.find(frame, ["base", "jaw", "bolt"], assembled) == []
    assert finder.find(frame, [], {}) == []
    assert finder.find(frame, ["jaw"], None) == []


def test_a_place_behind_the_camera_is_none(finder_of, clamp, assembled, draw) -> None:
    base = assembled["base"]
    behind = type(base).from_rotation_translation(base.rotation, np.array([0.0, 0.0, 0.001]))
    assert finder_of().find(draw(clamp, assembled), ["jaw", "bolt"], {"base": behind}) == []


def test_without_depth_the_other_finder_is_left(finder_of, clamp, assembled, draw) -> None:
    seen = Hypothesis("jaw", assembled["jaw"], 0.9)
    frame = replace(draw(clamp, assembled), depth=None)
    assert finder_of(seen).find(frame, ["jaw", "bolt"], {"base": assembled["base"]}) == [seen]


def test_the_other_finder_is_asked_as_it_would_be(search, clamp, assembled, draw) -> None:
    blind = Blind()
    finder = JoinedFinder(blind, search)
    frame = draw(clamp, assembled)
    finder.find(frame, ["jaw"], {"base": assembled["base"]})
    assert blind.asked == [(frame.name, ("jaw",), {"base": assembled["base"]})]
    assert finder.names == blind.names
    assert finder.rejected == {"low_score": 3}


def test_twice_the_same(finder_of, clamp, assembled, draw) -> None:
    frame, finder = draw(clamp, assembled), finder_of()
    known = {"base": assembled["base"]}
    one, other = (finder.find(frame, ["jaw", "bolt"], known) for _ in range(2))
    assert [each.part for each in one] == [each.part for each in other]
    for each, again in zip(one, other, strict=True):
        np.testing.assert_array_equal(each.camera_from_body.matrix, again.camera_from_body.matrix)


def test_without_open3d_finders_stand_alone(bodies, camera, monkeypatch) -> None:
    def missing():
        raise TrackingError("no Open3D here")

    alone = [("network", Blind())]
    monkeypatch.setattr("snapfit.tracking.finding.joined.open3d", missing)
    assert with_links(alone, bodies, camera, ASSET) == alone


def test_where_there_are_no_links_nothing_stands_before_a_finder(bodies, camera) -> None:
    alone = [("geometric", Blind()), ("network", Blind())]
    assert with_links(alone, bodies, camera, None) == alone
    assert with_links(alone, bodies, replace(camera, depth=None), ASSET) == alone
    assert with_links(alone, bodies, camera, replace(ASSET, states=())) == alone
    both = with_links(alone, bodies, camera, ASSET)
    assert [kind for kind, _ in both] == ["geometric", "network"]
    assert all(isinstance(each, JoinedFinder) for _, each in both)
