"""The benches of the test split: unlike each other, from a seed alone, with room for all parts."""

import itertools

import cv2
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.workbench import tables
from snapfit.models.workbench.bench import Table, sampled_scene, table_of
from snapfit.models.workbench.clutter import scattered
from snapfit.models.workbench.dataset import Order, asset_seed
from snapfit.models.workbench.layout import laid_out
from snapfit.models.workbench.mounting import plan_mounts
from snapfit.models.workbench.scene import TEXELS_PER_M
from snapfit.models.workbench.split import TEST_FRAMES

WHITE = [(255, 255, 255)]
SIZE = (300, 400)


def test_the_split_has_tops_of_wood_cloth_paint_and_a_mat(tmp_path):
    order = Order(tmp_path)
    tops = {name: table_of(asset_seed(order, find_asset(name))) for name in TEST_FRAMES}
    assert set(tops.values()) == set(Table)


def test_a_seed_gives_one_bench_and_another_seed_another():
    one, same, other = (sampled_scene(seed, WHITE) for seed in (2001, 2001, 2005))
    assert (one.ground == same.ground).all()
    assert (one.camera_from_world.matrix == same.camera_from_world.matrix).all()
    assert one.lamps == same.lamps
    for a, b in zip(one.items, same.items, strict=True):
        assert (a.world_from_body.matrix == b.world_from_body.matrix).all()
        assert a.color_rgb == b.color_rgb
    assert (one.ground != other.ground).mean() > 0.5
    assert one.camera_from_world.distance_to(other.camera_from_world) > 0.005


@pytest.mark.parametrize("name", TEST_FRAMES)
def test_all_parts_lie_in_view_and_clear_of_the_things(name, tmp_path):
    asset = find_asset(name)
    seed = asset_seed(Order(tmp_path), asset)
    scene = sampled_scene(seed, [part.color_rgb for part in asset.parts])
    poses = laid_out(asset, scene, plan_mounts(asset), np.random.default_rng((seed, 0)))
    things = [hull(item.world_from_body.transform(item.mesh.vertices)) for item in scene.items]
    for part in asset.parts:
        points = poses[part.name].transform(part.mesh.vertices)
        pixels = scene.camera.project(scene.camera_from_world.transform(points))
        assert (pixels > 0).all()
        assert (pixels < [scene.camera.width, scene.camera.height]).all()
        own = hull(points)
        assert all(cv2.intersectConvexConvex(own, thing)[0] < 1e-6 for thing in things)


def hull(points):
    """In mm, because the areas are small."""
    return cv2.convexHull((points[:, :2] * 1000).astype(np.float32))


def test_things_stand_apart():
    for seed in range(6):
        items = scattered(np.random.default_rng(seed))
        by_place = {}
        for item in items:
            points = item.world_from_body.transform(item.mesh.vertices)
            by_place.setdefault(tuple(item.world_from_body.translation), []).append(points)
        assert len(by_place) >= 6
        outlines = [hull(np.vstack(clouds)) for clouds in by_place.values()]
        for a, b in itertools.combinations(outlines, 2):
            assert cv2.intersectConvexConvex(a, b)[0] < 1e-6


@pytest.mark.parametrize("table", [Table.CLOTH, Table.COATED])
def test_the_top_is_of_a_colour_that_stands_out_from_the_parts(table):
    seed = next(s for s in range(2000, 2004) if table_of(s) is table)
    one = sampled_scene(seed, [(92, 108, 130), (98, 110, 124)])
    mean = np.median(one.ground.reshape(-1, 3)[:, ::-1], axis=0)
    assert np.abs(mean - (95, 109, 127)).max() > 25


@pytest.mark.parametrize("paint", [tables.cloth, tables.coated, tables.cutting_mat])
def test_a_top_has_its_colour_and_a_texture(paint):
    color = (60, 120, 90)
    top = paint(np.random.default_rng(3), SIZE, TEXELS_PER_M, color)
    again = paint(np.random.default_rng(3), SIZE, TEXELS_PER_M, color)
    assert top.shape == (*SIZE, 3)
    assert (top == again).all()
    red, green, blue = np.median(top.reshape(-1, 3)[:, ::-1], axis=0)
    assert green > blue > red
    assert 2 < cv2.cvtColor(top, cv2.COLOR_BGR2GRAY).std() < 40


def test_a_mat_has_lines_a_centimetre_apart():
    mat = tables.cutting_mat(np.random.default_rng(0), (500, 500), 1000, (34, 88, 74))
    profile = mat[20:480].astype(float).mean(axis=(0, 2))
    lines = np.flatnonzero(profile > profile.mean() + 15)
    starts = lines[np.insert(np.diff(lines) > 1, 0, True)]
    assert len(starts) > 40
    np.testing.assert_allclose(np.diff(starts), 10, atol=1.01)
