"""How parts in each other are measured, and that the assembly's ways keep clear."""

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import find_asset
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.workbench.assembly import timed_assembly
from snapfit.models.workbench.bench import sampled_scene
from snapfit.models.workbench.choreography import Bodies
from snapfit.models.workbench.dataset import Order, asset_seed
from snapfit.models.workbench.split import FRAME_RATE_HZ, TEST_FRAMES

ABOVE = Pose.from_translation(0, 0, 0.2)


@pytest.fixture(scope="module")
def clearance():
    cube = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh = Mesh(cube.vertices, cube.faces)
    return Bodies.of({"one": mesh, "other": mesh}).clearance


def shifted(x):
    return {"one": Pose.from_translation(x, 0, 0) @ ABOVE}


def test_the_overlap_is_a_share_of_the_volume(clearance):
    standing = {"other": ABOVE}
    assert clearance.overlap(shifted(0.025), standing) == pytest.approx(0.75, abs=1e-4)
    assert clearance.overlap(shifted(0.0999), standing) == 0
    assert clearance.overlap(shifted(0.3), standing) == 0


def test_what_is_in_the_bench_counts_by_its_depth(clearance):
    for z_m, expected in ((0.05, 0.0), (0.049, 0.0), (0.03, 1.0), (-0.5, 27.5)):
        pose = Pose.from_translation(0, 0, z_m)
        assert clearance.overlap({"one": pose}, {}) == pytest.approx(expected, abs=1e-4)


def test_the_worst_of_a_way_counts_and_what_is_joined_comes_along(clearance):
    ways = [shifted(x)["one"] for x in (0.3, 0.05, -0.2)]
    alone = {"one": Pose.identity()}
    assert clearance.worst(ways, alone, {"other": ABOVE}) == pytest.approx(0.5, abs=1e-4)
    beside = {"other": Pose.from_translation(0, 0, -0.3), "one": Pose.identity()}
    assert clearance.worst([ABOVE], beside, {}) == pytest.approx(7.5, abs=1e-3)


@pytest.mark.parametrize(
    "name",
    [
        "geared-caliper",
        pytest.param("liftpod", marks=pytest.mark.slow),
        pytest.param("hand-screw-clamp", marks=pytest.mark.slow),
        pytest.param("nano-chuck", marks=pytest.mark.slow),
        "hobby-corner-clamp",
    ],
)
def test_no_part_goes_through_the_bench_or_far_into_another(name, tmp_path):
    asset, n = find_asset(name), TEST_FRAMES[name]
    seed = asset_seed(Order(tmp_path), asset)
    scene = sampled_scene(seed, [part.color_rgb for part in asset.parts])
    script = timed_assembly(asset, scene, n, seed)
    clearance = Bodies.of({part.name: part.mesh for part in asset.parts}).clearance
    for frame in np.arange(0, n, 8):
        poses = script.poses_at(frame / FRAME_RATE_HZ)
        for part in poses:
            others = {other: pose for other, pose in poses.items() if other > part}
            assert clearance.overlap({part: poses[part]}, others) < 0.12
