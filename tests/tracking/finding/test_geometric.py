"""The geometric finder on drawn benches, where the answer is known."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.asset import Part
from snapfit.models.camera import AZURE_KINECT_720P, PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.finding.finder import Finder, Hypothesis
from snapfit.tracking.finding.geometric import GeometricFinder
from snapfit.tracking.frame import Frame
from snapfit.tracking.metrics import add_s_m, model_vertices

pytestmark = pytest.mark.usefixtures("needs_open3d")


@pytest.fixture(scope="module")
def finder(needs_open3d: None, bodies: tuple[Body, ...], camera: RgbdCamera) -> GeometricFinder:
    return GeometricFinder(bodies, camera)


def assert_found(
    hypotheses: list[Hypothesis], parts: tuple[Part, ...], truth: Mapping[str, Pose]
) -> None:
    """Each part's first hypothesis is where it lies; no other part is claimed."""
    assert {each.part for each in hypotheses} == set(truth)
    for part in parts:
        if part.name in truth:
            first = next(each for each in hypotheses if each.part == part.name)
            error_m = add_s_m(model_vertices(part.mesh), first.camera_from_body, truth[part.name])
            assert error_m < 0.003, part.name
            assert 0.7 <= first.score <= 1


def test_all_parts_on_the_bench_are_found(finder, clamp, lying, draw):
    found = finder.find(draw(clamp, lying), finder.names)
    assert_found(found, clamp, lying)


def test_it_is_a_finder(finder: GeometricFinder):
    as_protocol: Finder = finder
    assert as_protocol.names == ("base", "jaw", "bolt")


def test_only_what_is_wanted_is_told(finder, clamp, lying, draw):
    found = finder.find(draw(clamp, lying), ["jaw"])
    assert_found(found, clamp, {"jaw": lying["jaw"]})
    assert finder.find(draw(clamp, lying), []) == []


def test_the_same_frame_gives_the_same_poses(finder, clamp, lying, draw):
    frame = draw(clamp, lying)
    once, again = finder.find(frame, ["jaw"]), finder.find(frame, ["jaw"])
    assert [each.score for each in once] == [each.score for each in again]
    assert np.array_equal(once[0].camera_from_body.matrix, again[0].camera_from_body.matrix)


def test_a_part_out_of_view_is_not_claimed(finder, clamp, lying, draw):
    there = {name: lying[name] for name in ("base", "bolt")}
    assert_found(finder.find(draw(clamp, there), finder.names), clamp, there)


def test_nothing_is_found_on_an_empty_bench(finder, clamp, draw):
    assert finder.find(draw(clamp, {}), finder.names) == []


def test_nothing_is_found_without_depth(finder, clamp, lying, draw):
    frame = draw(clamp, lying)
    assert frame.depth is not None
    for depth in (None, np.zeros_like(frame.depth), np.full_like(frame.depth, 65535)):
        assert finder.find(replace(frame, depth=depth), finder.names) == []


def test_parts_are_found_where_there_is_no_plane(finder, clamp, lying, draw):
    heights_m = {"base": 0.0, "jaw": 0.12, "bolt": 0.06}
    hovering = {
        name: Pose.from_translation(0, -height_m, -height_m) @ lying[name]
        for name, height_m in heights_m.items()
    }
    found = finder.find(draw(clamp, hovering, bench=False), finder.names)
    assert_found(found, clamp, hovering)


def test_a_thing_that_is_no_part_is_not_claimed(finder, clamp, lying, draw):
    jaw = clamp[1]
    extent = np.ptp(jaw.mesh.vertices, axis=0)
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3, indexing="ij")).reshape(3, -1).T
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    faces += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    box = Mesh((corners * extent).astype(np.float32), np.array(faces, dtype=np.int32))
    other = Part("box", box, jaw.color_rgb)
    middle = lying["jaw"].transform(jaw.mesh.center_m)
    pose = Pose.from_rotation_translation(Pose.exp([0.8, 0.5, 0, 0, 0, 0]).rotation, middle)
    assert finder.find(draw([other], {"box": pose}), finder.names) == []


def test_parts_that_look_the_same_get_a_place_each(camera, clamp, bodies, lying, draw):
    jaw, body = clamp[1], bodies[1]
    twin, twin_body = replace(jaw, name="twin"), replace(body, name="twin")
    poses = {"jaw": lying["jaw"], "twin": _moved(lying["jaw"], [-0.14, 0.0, 0.0])}
    finder = GeometricFinder((body, twin_body), camera)
    found = finder.find(draw((jaw, twin), poses), finder.names)
    first = {each.part: each.camera_from_body for each in reversed(found)}
    places = [pose.translation[0] for pose in poses.values()]
    assert sorted(pose.translation[0] for pose in first.values()) == pytest.approx(
        sorted(places), abs=0.003
    )
    # Who knows where the one is finds the other: each may be at both.
    assert sorted(each.part for each in found) == ["jaw", "jaw", "twin", "twin"]


def test_the_depth_camera_may_stand_elsewhere(clamp, bodies, lying, draw):
    depth = PinholeCamera(640, 576, 504.0, 504.0, 320.0, 288.0)
    color_from_depth = Pose.exp([0.1, 0.02, -0.01, -0.032, 0.002, 0.004])
    camera = RgbdCamera(AZURE_KINECT_720P, depth, 0.0005, color_from_depth)
    frame = draw(clamp, lying, camera=camera)
    finder = GeometricFinder(bodies, camera)
    assert_found(finder.find(frame, finder.names), clamp, lying)


def test_an_unknown_part_is_refused(finder, clamp, lying, draw):
    with pytest.raises(TrackingError, match="no part 'lid' to find; the parts are base, jaw, bolt"):
        finder.find(draw(clamp, lying), ["lid"])


def test_a_frame_of_another_camera_is_refused(finder):
    frame = Frame("7", 0, np.zeros((480, 640, 3), dtype=np.uint8))
    with pytest.raises(FrameError, match="frame 7: the colour image"):
        finder.find(frame, finder.names)


def test_it_needs_a_depth_camera_and_parts(bodies, camera):
    with pytest.raises(TrackingError, match="needs a depth camera"):
        GeometricFinder(bodies, RgbdCamera(AZURE_KINECT_720P))
    with pytest.raises(TrackingError, match="no part to find"):
        GeometricFinder((), camera)


def _moved(pose: Pose, shift_m: list[float]) -> Pose:
    return Pose.from_translation(*shift_m) @ pose
