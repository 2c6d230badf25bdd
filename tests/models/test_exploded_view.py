"""Exploded views: every part is seen, apart from the others, named, and in frame."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Asset, Part, bundled_names, find_asset
from snapfit.models.exploded_labels import place_labels
from snapfit.models.exploded_layout import exploded, final_links
from snapfit.models.exploded_view import exploded_view
from snapfit.models.manifest import Link, State
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose


@pytest.fixture(scope="module", params=bundled_names())
def drawn(request):
    asset = find_asset(request.param)
    return asset, exploded_view(asset)


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def test_every_part_is_seen_in_its_colour(drawn):
    asset, view = drawn
    counts = np.bincount(view.part_id.ravel(), minlength=len(asset.parts) + 1)[1:]
    assert (counts > 500).all(), dict(zip([p.name for p in asset.parts], counts, strict=True))
    for i, part in enumerate(asset.parts):
        mean = view.image[view.part_id == i + 1].mean(axis=0)[::-1]
        other = [
            np.linalg.norm(mean / mean.sum() - np.divide(each.color_rgb, sum(each.color_rgb)))
            for each in asset.parts
        ]
        own = other[i]
        assert own < min(other) + 0.03, part.name


def test_parts_keep_clear_of_the_border_on_white(drawn):
    _, view = drawn
    border = np.ones(view.part_id.shape, dtype=bool)
    border[12:-12, 12:-12] = False
    assert (view.image[border] == 255).all()
    assert (view.image[view.part_id == 0] > 250).all(axis=-1).mean() > 0.9


def test_every_part_has_its_name_beside_it(drawn):
    asset, view = drawn
    assert set(view.labels) == {part.name for part in asset.parts}
    height, width = view.part_id.shape
    for left, top, right, bottom in view.labels.values():
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= height
        assert not view.part_id[top:bottom, left:right].any()
        assert (view.image[top:bottom, left:right] < 100).any(axis=-1).sum() > 30
    for a, b in itertools.combinations(view.labels.values(), 2):
        assert not overlap(a, b)


def test_linked_parts_go_apart_along_their_ways(drawn):
    asset, _ = drawn
    layout = exploded(asset)
    assert len(layout.ways) == len(final_links(asset)) == len(asset.parts) - 1
    for link, way in zip(final_links(asset), layout.ways, strict=True):
        assert np.linalg.norm(way[1] - way[0]) > 0.008, link.child
        there = layout.world_from_part[link.parent].inverse()
        between = there @ layout.world_from_part[link.child]
        # Parts are moved, not turned, and the way is that motion.
        assert between.angle_to(link.parent_from_child) < 1e-6
        motion = between.translation - link.parent_from_child.translation
        np.testing.assert_allclose(there.rotation @ (way[1] - way[0]), motion, atol=1e-9)


def test_the_same_picture_every_time():
    asset = find_asset("hobby-corner-clamp")
    assert np.array_equal(exploded_view(asset).image, exploded_view(asset).image)


def boxes(links=()):
    box = trimesh.creation.box((0.04, 0.03, 0.02))
    mesh = Mesh(box.vertices.astype(np.float32), box.faces.astype(np.int32))
    parts = tuple(Part(name, mesh, (200, 40 + 60 * i, 40)) for i, name in enumerate("abc"))
    asset = replace(find_asset("hobby-corner-clamp"), parts=parts, states=(), steps=())
    if not links:
        return asset
    return replace(asset, states=(State(name="apart"), State(name="on", link=tuple(links))))


def distances(asset: Asset) -> list[float]:
    poses = exploded(asset).world_from_part
    return [
        float(np.linalg.norm(poses[a].translation - poses[b].translation)) for a, b in ("ab", "bc")
    ]


def test_parts_without_links_stand_side_by_side():
    view = exploded_view(boxes())
    columns = [np.flatnonzero((view.part_id == i).any(axis=0)) for i in (1, 2, 3)]
    assert all(len(each) for each in columns)
    assert exploded(boxes()).ways == ()
    assert min(distances(boxes())) > 0.03


def test_without_steps_the_state_with_most_links_is_drawn():
    stacked = Pose.from_translation(0, 0, 0.02)
    links = [
        Link(parent=a, child=b, parent_from_child=stacked, joint={"type": "fixed"})
        for a, b in ("ab", "bc")
    ]
    asset = boxes(links)
    assert final_links(asset) == tuple(links)
    # Each goes on its own height, its gap included.
    assert all(distance > 0.022 for distance in distances(asset))
    assert len(exploded(asset).ways) == 2


def test_names_find_a_place_where_it_is_narrow():
    part_id = np.zeros((200, 400), dtype=np.uint8)
    part_id[90:110, 20:380] = 1
    part_id[120:140, 20:380] = 2
    labels = place_labels(["upper", "lower"], part_id, part_id > 0)
    for label in labels:
        left, top, right, bottom = label.box
        assert not part_id[top:bottom, left:right].any()
        assert part_id[label.anchor[1], label.anchor[0]] > 0
    assert not overlap(labels[0].box, labels[1].box)


def test_a_part_that_is_not_seen_gets_no_name():
    part_id = np.zeros((100, 200), dtype=np.uint8)
    part_id[40:60, 40:60] = 2
    assert [label.name for label in place_labels(["a", "b"], part_id, part_id > 0)] == ["b"]
