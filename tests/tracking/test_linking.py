"""Where parts stand once their state's links hold them."""

import numpy as np
import pytest

from snapfit.models.asset import Asset, find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.viewpoint_model import ViewpointModel
from snapfit.tracking.body import Body
from snapfit.tracking.linking import Linker
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import TrackerParameters

BENCH = Pose.from_translation(0.02, -0.01, 0.65) @ Pose.exp([0.5, 0.6, -0.3, 0, 0, 0])
NO_VIEWS = ViewpointModel(
    center_m=np.zeros(3),
    radius_m=0.8,
    directions=np.array([[0, 0, 1]], dtype=np.float32),
    neighbours=np.zeros((1, 6), dtype=np.int16),
    unit_m=1e-5,
    contour=np.zeros((1, 300, 9), dtype=np.int16),
    surface=np.zeros((1, 300, 7), dtype=np.int16),
    contour_length_m=np.ones(1, dtype=np.float32),
    surface_area_m2=np.ones(1, dtype=np.float32),
)


@pytest.fixture(scope="module")
def asset() -> Asset:
    return find_asset("hand-screw-clamp")


@pytest.fixture
def optimiser(asset: Asset) -> Optimiser:
    camera = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
    bodies = [Body(part.name, part.mesh, NO_VIEWS) for part in asset.tracked_parts]
    return Optimiser(bodies, camera, TrackerParameters())


def links_of(asset: Asset, state: str):
    return next(each.links for each in asset.states if each.name == state)


def test_a_module_that_is_seen_is_not_turned_by_what_is_put_on_its_hidden_end(
    asset, optimiser
) -> None:
    """A knob may be seen upside down as well: what carries it is not to follow it in that."""
    names = [part.name for part in asset.tracked_parts]
    linker = Linker(asset.tracked_parts, optimiser, is_rigid=False)
    for i, _ in enumerate(names):
        optimiser.place(i, BENCH)
    seen = dict.fromkeys(names, True)
    linker.apply(links_of(asset, "first-knob-on"), seen)
    before = {name: optimiser.pose(i) for i, name in enumerate(names)}
    last = next(link for link in links_of(asset, "assembled") if link.child == "knob-2")
    knob, parent = names.index("knob-2"), names.index(last.parent)
    assert len(optimiser.structures.members(parent)) > 1
    upside_down = Pose.exp([np.pi, 0, 0, 0, 0, 0])
    optimiser.move(knob, optimiser.pose(parent) @ upside_down)
    linker.apply(links_of(asset, "assembled"), seen | {last.parent: False})
    for i, name in enumerate(names):
        if name != "knob-2":
            assert optimiser.pose(i).distance_to(before[name]) < 1e-6, name
            assert optimiser.pose(i).angle_to(before[name]) < 1e-6, name


def test_a_module_that_nobody_sees_goes_with_the_part_that_is_seen(asset, optimiser) -> None:
    names = [part.name for part in asset.tracked_parts]
    linker = Linker(asset.tracked_parts, optimiser, is_rigid=False)
    for i, _ in enumerate(names):
        optimiser.place(i, BENCH)
    link = links_of(asset, "pad-on")[0]
    child = names.index(link.child)
    moved = Pose.from_translation(0.05, 0.0, 0.0) @ optimiser.pose(child)
    optimiser.move(child, moved)
    seen = dict.fromkeys(names, True) | {link.parent: False}
    linker.apply(links_of(asset, "pad-on"), seen)
    assert optimiser.pose(child).distance_to(moved) < 1e-6
    assert optimiser.pose(child).angle_to(moved) < 1e-6
