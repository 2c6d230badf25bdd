"""What training images are put together from: modules, rest, room, foreign shapes, light."""

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import count_open_edges
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import intrinsics_of
from snapfit.models.workbench import train_kernels
from snapfit.models.workbench.backdrops import SIDE_PX
from snapfit.models.workbench.distractors import distractor_meshes
from snapfit.models.workbench.scene import linear, looking_at
from snapfit.models.workbench.shading import encoding
from snapfit.models.workbench.train_colors import painted
from snapfit.models.workbench.train_modules import Modules, Space, afloat, resting

CAMERA = PinholeCamera(64, 48, 50, 52, 31, 24)


@pytest.fixture(scope="module")
def asset():
    return find_asset("liftpod")


def test_foreign_shapes_are_closed_and_of_the_size_of_parts():
    meshes = distractor_meshes(28, np.random.default_rng(0))
    assert [count_open_edges(mesh.faces) for mesh in meshes] == [0] * 28
    assert all(0.01 < mesh.diameter_m < 0.25 for mesh in meshes)
    assert len({mesh.digest for mesh in meshes}) == 28
    again = distractor_meshes(28, np.random.default_rng(0))
    assert [mesh.digest for mesh in again] == [mesh.digest for mesh in meshes]


def test_parts_are_joined_as_the_state_says_within_the_limits_of_joints(asset):
    modules, rng = Modules(asset), np.random.default_rng(1)
    states = {state.name: state for state in asset.states}
    moved = 0
    for _ in range(30):
        found, name = modules.sampled(True, rng)
        together = [{part.name: pose for part, pose in module.parts} for module in found]
        for link in states[name].links:
            (poses,) = [each for each in together if link.child in each and len(each) > 1]
            stands = poses[link.parent].inverse() @ poses[link.child]
            off = link.parent_from_child.inverse() @ stands
            if link.joint.axis is None:
                np.testing.assert_allclose(off.matrix, np.eye(4), atol=1e-9)
                continue
            axis = np.array(link.joint.axis) / np.linalg.norm(link.joint.axis)
            point = np.array(link.joint.point_m)
            travel = (off.transform(point) - point) @ axis
            turn = np.degrees(off.log()[:3] @ axis)
            np.testing.assert_allclose(off.rotation @ axis, axis, atol=1e-9)
            if link.joint.travel_m:
                assert link.joint.travel_m[0] - 1e-9 <= travel <= link.joint.travel_m[1] + 1e-9
            if link.joint.turn_deg:
                # The logarithm is between half a turn to either side.
                low, high = link.joint.turn_deg
                assert any(low - 1e-6 <= turn + 360 * k <= high + 1e-6 for k in (-1, 0, 1))
            moved += abs(travel) > 1e-4 or abs(turn) > 0.1
    assert moved > 10


def test_without_a_state_every_part_is_alone(asset):
    modules, rng = Modules(asset), np.random.default_rng(2)
    for _ in range(10):
        found, name = modules.sampled(False, rng)
        assert name is None
        assert all(len(module.parts) == 1 for module in found)
    names = {module.parts[0][0].name for module in found}
    assert len(names) >= len(asset.parts) // 2


def test_what_rests_stands_on_the_bench_on_a_side_of_its_hull(asset):
    modules, rng = Modules(asset), np.random.default_rng(3)
    found, _ = modules.sampled(True, rng)
    for module in found:
        for _ in range(5):
            heights = resting(module, rng).transform(module.points)[:, 2]
            assert abs(heights.min()) < 1e-9
            # It stands on a face: on three points at least.
            assert (heights < 2e-4).sum() >= 3
        middle = afloat(module, rng).transform(module.points)
        np.testing.assert_allclose(middle.min(axis=0), -middle.max(axis=0), atol=1e-9)


def test_no_two_things_take_the_same_room():
    space = Space(gap=True)
    cube = np.stack(np.meshgrid(*[np.linspace(0, 0.03, 9)] * 3), -1).reshape(-1, 3)
    assert space.take(cube)
    assert not space.take(cube + np.array((0.028, 0, 0)))
    assert space.take(cube + np.array((0.05, 0, 0)))
    assert not space.take(cube + np.array((2.0, 0, 0)))
    assert not space.take(cube - np.array((0, 0, 0.2)))


def test_parts_of_one_plastic_stay_of_one_colour(asset):
    rng = np.random.default_rng(4)
    same = total = 0
    for _ in range(40):
        colors = painted(asset.parts, rng)
        for one in asset.parts:
            for other in asset.parts:
                if one.name < other.name and one.color_rgb == other.color_rgb:
                    same += colors[one.name] == colors[other.name]
                    total += 1
    assert 0.8 < same / total < 1.0


def floor_sheets(view, **changes):
    rows = {
        "frames": view.matrix[None, :3].copy(),
        "halves": np.array([[0.3, 0.2]]),
        "windows": np.array([[0, CAMERA.width, 0, CAMERA.height]]),
        "surface": np.array([0]),
        "texels": np.array([[1000.0, 0.0, 0.0, 0.0]]),
        "color": np.array([np.eye(3, 4)], np.float32),
        "gloss": np.array([0.25], np.float32),
        **changes,
    }
    return train_kernels.Sheets(**rows)


def rays():
    columns, rows = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    return np.stack([x, y, np.ones_like(x)], -1)


def test_flat_things_are_hit_where_the_rays_meet_them():
    view = looking_at((0.1, -0.4, 0.5), (0, 0, 0))
    depth, which = np.empty((48, 64), np.float32), np.empty((48, 64), np.uint8)
    train_kernels.hit_sheets(floor_sheets(view), intrinsics_of(CAMERA), depth, which)
    eye = view.inverse()
    directions = rays() @ eye.rotation.T
    expected = -eye.translation[2] / directions[..., 2]
    points = eye.translation + expected[..., None] * directions
    inside = (np.abs(points[..., 0]) < 0.3) & (np.abs(points[..., 1]) < 0.2) & (expected > 0)
    np.testing.assert_array_equal(which > 0, inside)
    np.testing.assert_allclose(depth[inside], expected[inside], rtol=1e-5)
    assert (depth[~inside] == 0).all()
    assert 0.1 < inside.mean() < 0.9


def test_surfaces_are_seen_in_their_place_and_far_ones_in_their_mean():
    view = Pose.from_rotation_translation(np.diag([1.0, -1.0, -1.0]), (0, 0, 0.5))
    rng = np.random.default_rng(5)
    base = np.repeat(np.repeat(rng.integers(0, 256, (96, 96, 3), np.uint8), 8, 0), 8, 1)
    stock = np.zeros((1, SIDE_PX, 2 * SIDE_PX, 3), np.uint8)
    stock[0, :, :SIDE_PX] = base
    stock[0, :, SIDE_PX:] = 77
    shape = (CAMERA.height, CAMERA.width)
    depth, which = np.empty(shape, np.float32), np.empty(shape, np.uint8)
    normal, albedo = (np.empty((*shape, 3), np.float32) for _ in range(2))
    gloss = np.empty(shape, np.float32)

    def painted_with(pixels_per_m):
        texels = np.array([[pixels_per_m, 0.0, 100.0, 200.0]])
        sheets = floor_sheets(view, texels=texels, halves=np.array([[9.0, 9.0]]))
        train_kernels.hit_sheets(sheets, intrinsics_of(CAMERA), depth, which)
        train_kernels.paint_sheets(
            sheets,
            stock,
            linear(np.arange(256, dtype=np.uint8)),
            intrinsics_of(CAMERA),
            depth,
            which,
            normal,
            albedo,
            gloss,
        )
        return albedo.copy()

    near = painted_with(110.0)
    points = rays() * 0.5
    s, t = 110 * points[..., 0] + 100, -110 * points[..., 1] + 200
    # In the middle of the squares nothing is mixed with a neighbour.
    clear = (np.abs(s / 8 % 1 - 0.5) < 0.35) & (np.abs(t / 8 % 1 - 0.5) < 0.35)
    expected = linear(base[t[clear].astype(int), s[clear].astype(int)])
    np.testing.assert_allclose(near[clear], np.clip(expected, 0.004, 0.92), atol=2e-5)
    assert clear.mean() > 0.3
    np.testing.assert_allclose(normal[..., 2], -1.0)
    assert (gloss == np.float32(0.25)).all()
    far = painted_with(4000.0)
    np.testing.assert_allclose(far, linear(np.array(77, np.uint8)), atol=1e-5)


def test_exposure_is_srgb_below_the_shoulder_and_never_wraps_above():
    light = np.linspace(0, 5, 3 * 400, dtype=np.float32).reshape(20, 20, 3)
    gain = np.array([0.5, 0.5, 0.5], np.float32)
    seen = train_kernels.expose(light, gain, 0.0, 0.8, encoding())
    value = light * 0.5
    srgb = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055) * 255
    low = value < 0.79
    assert np.abs(seen[low] - srgb[low]).max() <= 1.0
    assert (np.diff(seen.reshape(-1).astype(int)) >= 0).all()
    darker = train_kernels.expose(light, gain, 0.4, 0.8, encoding())
    assert darker[0, 10, 0] < seen[0, 10, 0] or seen[0, 10, 0] == 0
    assert darker[10, 10, 1] == seen[10, 10, 1]
