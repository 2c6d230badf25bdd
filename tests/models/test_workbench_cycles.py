"""Photo-real pictures by Blender: the camera is ours to the pixel, and the scene is seen."""

import sys
from importlib.util import find_spec

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.camera import PinholeCamera
from snapfit.models.errors import DatasetError, WorkbenchError
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.workbench.blender import check_bpy
from snapfit.models.workbench.cycles import Cycles, CyclesFilm
from snapfit.models.workbench.dataset import Order, render_dataset
from snapfit.models.workbench.fan_out import claim_folder
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.hand import Body
from snapfit.models.workbench.scene import standard_scene
from snapfit.models.workbench.split import Condition

CLAMP = "hobby-corner-clamp"

needs_blender = pytest.mark.skipif(
    find_spec("bpy") is None, reason="bpy is not installed: pip install 'snapfit[blender]'"
)


@pytest.fixture
def without_blender(monkeypatch):
    monkeypatch.setitem(sys.modules, "bpy", None)
    monkeypatch.setattr("snapfit.models.workbench.blender.find_spec", lambda _: None)


def test_without_blender_one_is_told_what_to_install(without_blender, tmp_path):
    with pytest.raises(WorkbenchError, match=r"pip install 'snapfit\[blender\]'"):
        check_bpy()
    order = Order(tmp_path / "dataset", (CLAMP,), (Condition.NORMAL,), limit=1, cycles_samples=4)
    with pytest.raises(WorkbenchError, match=r"Python 3\.11"):
        render_dataset(order, jobs=1)
    assert not (tmp_path / "dataset").exists()


def test_pictures_of_two_renderers_do_not_mix(tmp_path):
    claim_folder(tmp_path, {"seed": 1, "cycles_samples": 8})
    with pytest.raises(DatasetError, match=r"\(cycles_samples\)"):
        claim_folder(tmp_path, {"seed": 1})


def test_there_is_no_second_camera_beside_blenders():
    with pytest.raises(WorkbenchError, match="Cycles has one camera"):
        CyclesFilm.beside(object.__new__(CyclesFilm), Pose.identity())


def ids_by_blender(cycles, bodies, shape):
    """(H, W) the number of the body at each pixel's centre: all glow in their own grey."""
    import bpy

    cycles.picture(bodies, [], np.zeros((2, 3)), samples=1)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    for thing in scene.objects:
        grey = thing.pass_index / 16
        thing.color = (grey, grey, grey, 1.0)
    glow = bpy.data.materials.new("glow")
    glow.use_nodes = True
    nodes = glow.node_tree.nodes
    nodes.clear()
    emission, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    color = nodes.new("ShaderNodeObjectInfo").outputs["Color"]
    glow.node_tree.links.new(color, emission.inputs["Color"])
    glow.node_tree.links.new(emission.outputs[0], out.inputs["Surface"])
    layer.material_override = glow
    scene.cycles.use_denoising, scene.cycles.max_bounces = False, 0
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    seen = cycles.rendered()
    assert seen.shape == (*shape, 3)
    return np.rint(seen[..., 0] * 16).astype(int)


@needs_blender
@pytest.mark.parametrize(
    "camera",
    [
        PinholeCamera(320, 180, 151.8, 151.8, 159.4, 90.8),
        PinholeCamera(320, 180, 190.0, 152.0, 121.0, 118.0),
        PinholeCamera(240, 260, 150.0, 185.0, 140.0, 105.0),
    ],
    ids=["standard", "wide-pixels", "high-pixels"],
)
def test_parts_are_where_the_rasteriser_draws_them(camera):
    asset = find_asset(CLAMP)
    scene = standard_scene(np.random.default_rng(1)).scaled(1.0)
    scene = type(scene)(**{**vars(scene), "camera": camera, "items": ()})
    world = scene.camera_from_world.inverse()
    bodies, drawn = [], []
    for i, part in enumerate(asset.parts):
        camera_from_part = Pose.exp([0.5 + i, 0.3 - i, 0.7 * i, 0, 0, 0])
        place = ((i - 1) * 0.09, 0.03 - 0.03 * i, 0.32 + 0.03 * i)
        pose = Pose.from_rotation_translation(camera_from_part.rotation, place)
        drawn.append((part.mesh, pose))
        bodies.append(Body(part.mesh, world @ pose, part.color_rgb, 0.16))
    own = render(camera, drawn).part_id
    seen = ids_by_blender(Cycles(scene), bodies, own.shape)
    for i, part in enumerate(asset.parts):
        a, b = own == i + 1, seen == i + 1
        assert a.sum() > 300
        assert (a & b).sum() / (a | b).sum() > 0.98, part.name
        # Half a pixel of difference in what a pixel's centre is would show here.
        off = np.argwhere(a).mean(axis=0) - np.argwhere(b).mean(axis=0)
        assert np.abs(off).max() < 0.1, part.name


@needs_blender
@pytest.mark.parametrize("condition", [Condition.HAND, Condition.BLUR, Condition.DYNAMIC])
def test_a_frame_looks_like_that_of_the_own_renderer(condition):
    asset = find_asset(CLAMP)
    photo = CyclesFilm(asset, 60, 3, 0.25, samples=10).frame(20, condition)
    own = Film(asset, 60, 3, 0.25).frame(20, condition)
    assert photo.color.shape == own.color.shape == (180, 320, 3)
    assert 40 < photo.color.mean() < 200
    likeness = np.corrcoef(photo.color.ravel(), own.color.ravel())[0, 1]
    assert likeness > 0.85
    assert np.array_equal(photo.depth, own.depth)
    for name, sighting in own.sightings.items():
        assert np.array_equal(photo.sightings[name].mask, sighting.mask)


@needs_blender
def test_the_same_seed_gives_the_same_picture():
    film = CyclesFilm(find_asset(CLAMP), 60, 3, 0.15, samples=4)
    first, again = (film.frame(20, Condition.NORMAL).color for _ in range(2))
    assert np.array_equal(first, again)


@needs_blender
def test_a_dataset_is_rendered_by_cycles(tmp_path):
    order = Order(tmp_path, (CLAMP,), (Condition.NORMAL,), limit=2, scale=0.1, cycles_samples=2)
    summary = render_dataset(order, jobs=1)
    assert summary["frames"] == 2
    assert len(list((tmp_path / CLAMP / "test" / "normal" / "rgb").iterdir())) == 2
