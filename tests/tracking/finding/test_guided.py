"""Network and shape together, on drawn benches where the answer is known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from bench import ASSET, CAMERA, on_bench

from snapfit.models.asset import Part
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.detection.detector import Detection, Detections
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import Finder, Hypothesis
from snapfit.tracking.finding.guidance import guided
from snapfit.tracking.finding.guided import GuidedFinder
from snapfit.tracking.metrics import add_s_m, model_vertices

pytestmark = pytest.mark.usefixtures("needs_open3d")

TURNED = Pose.exp([0.9, -0.7, 0.8, 0, 0, 0])
Boxes = Sequence[tuple[str, Sequence[float], float]]


@dataclass
class Network:
    """Says boxes as a trained one would, and keypoints that lead astray."""

    names: tuple[str, ...]
    boxes: Boxes
    provider: str = "CPUExecutionProvider"
    rejected: Mapping[str, int] = field(default_factory=dict)

    def detect(self, frame):
        wrong = Pose.from_translation(0, 0, 2.0) @ TURNED
        presence = np.zeros(0, dtype=np.float32)
        found = [
            Detection(
                name,
                score,
                score,
                np.array(box),
                np.zeros((0, 2)),
                presence,
                presence > 0,
                9,
                wrong,
            )
            for name, box, score in self.boxes
        ]
        return Detections(frame.name, tuple(found))

    def find(self, frame, wanted, *_):
        found = self.detect(frame).found
        return [Hypothesis(e.part, e.camera_from_body, e.score) for e in found if e.part in wanted]


def around(part, pose, *, off_px: float = 3.0) -> list[float]:
    """The box of a whole part in the image, a little too large."""
    pixels = CAMERA.color.project(pose.transform(part.mesh.vertices))
    return [*(pixels.min(axis=0) - off_px), *(pixels.max(axis=0) + off_px)]


def boxes_of(parts, poses) -> list[tuple[str, list[float], float]]:
    return [(p.name, around(p, poses[p.name]), 0.8) for p in parts if p.name in poses]


def finder_of(parts, bodies, boxes: Boxes, camera=CAMERA) -> GuidedFinder:
    return GuidedFinder(Network(tuple(p.name for p in parts), boxes), bodies, camera)


def assert_found(found, parts, truth) -> None:
    assert {each.part for each in found} == set(truth)
    for part in parts:
        for each in found:
            if each.part == part.name:
                truly = truth[part.name]
                error_m = add_s_m(model_vertices(part.mesh), each.camera_from_body, truly)
                assert error_m < 0.003, part.name
                assert each.is_refined


def test_parts_are_found_where_keypoints_lead_astray(clamp, bodies, lying, draw):
    finder = finder_of(clamp, bodies, boxes_of(clamp, lying))
    as_protocol: Finder = finder
    assert_found(as_protocol.find(draw(clamp, lying), finder.names), clamp, lying)


def test_only_what_is_wanted_is_told(clamp, bodies, lying, draw):
    finder = finder_of(clamp, bodies, boxes_of(clamp, lying))
    found = finder.find(draw(clamp, lying), ["jaw"])
    assert_found(found, clamp, {"jaw": lying["jaw"]})
    assert finder.find(draw(clamp, lying), []) == []
    with pytest.raises(TrackingError, match="this finder finds base, jaw, bolt, not 'lid'"):
        finder.find(draw(clamp, lying), ["lid"])


def test_joined_parts_are_told_apart(clamp, bodies, draw):
    poses = joined(clamp[0])
    found = finder_of(clamp, bodies, boxes_of(clamp, poses)).find(draw(clamp, poses), list(poses))
    assert_found(found, clamp, poses)


def test_a_part_behind_something_is_found_by_what_is_left_of_it(clamp, bodies, lying, draw):
    frame = draw(clamp, lying)
    base = clamp[0]
    left, top, right, bottom = (round(each) for each in around(base, lying["base"]))
    color, depth = frame.color.copy(), frame.depth.copy()
    hand = np.s_[top : bottom + 1, left : left + (right - left) // 4]
    color[hand] = (60, 80, 200)
    depth[hand] = round(0.3 / CAMERA.depth_scale_m)
    finder = finder_of(clamp, bodies, boxes_of(clamp, lying))
    found = finder.find(replace(frame, color=color, depth=depth), ["base"])
    assert_found(found, clamp, {"base": lying["base"]})


def test_a_box_may_be_that_of_the_visible_piece_alone(clamp, bodies, lying, draw):
    """A hand holds one end, and the network boxes what it sees of the other."""
    frame, bolt = draw(clamp, lying), clamp[2]
    left, top, right, bottom = around(bolt, lying["bolt"])
    seen = left + 0.50 * (right - left)
    color, depth = frame.color.copy(), frame.depth.copy()
    hand = np.s_[round(top) : round(bottom) + 1, round(seen) : round(right) + 1]
    color[hand] = (60, 80, 200)
    depth[hand] = round(0.5 / CAMERA.depth_scale_m)
    boxes = [("bolt", (left, top, seen, bottom), 0.8)]
    held = replace(frame, color=color, depth=depth)
    found = finder_of(clamp, bodies, boxes).find(held, ["bolt"])
    assert_found(found, clamp, {"bolt": lying["bolt"]})


def test_nothing_is_told_of_a_box_around_another_part(clamp, bodies, lying, draw):
    boxes = [("bolt", around(clamp[0], lying["base"]), 0.9)]
    finder = finder_of(clamp, bodies, boxes)
    assert finder.find(draw(clamp, lying), ["bolt"]) == []
    assert sum(finder.rejected.values()) == 1


def test_nothing_is_told_of_a_box_around_nothing(clamp, bodies, lying, draw):
    boxes = [("jaw", (60.0, 500.0, 200.0, 620.0), 0.9), ("jaw", (1.0, 1.0, 1.5, 1.5), 0.5)]
    finder = finder_of(clamp, bodies, boxes)
    assert finder.find(draw(clamp, {}), ["jaw"]) == []
    assert finder.rejected["no_fit"] == 2


def test_a_wrong_candidate_does_not_hide_the_right_one(clamp, bodies, lying, draw):
    boxes = [
        ("jaw", around(clamp[0], lying["base"]), 0.9),
        ("jaw", around(clamp[1], lying["jaw"]), 0.4),
    ]
    found = finder_of(clamp, bodies, boxes).find(draw(clamp, lying), ["jaw"])
    assert_found(found, clamp, {"jaw": lying["jaw"]})


def test_of_two_parts_that_claim_a_place_the_right_one_gets_it(clamp, bodies, lying, draw):
    box = around(clamp[1], lying["jaw"])
    boxes = [("jaw", box, 0.5), ("base", box, 0.9)]
    found = finder_of(clamp, bodies, boxes).find(draw(clamp, lying), ["jaw", "base"])
    assert_found(found, clamp, {"jaw": lying["jaw"]})


def test_twins_share_candidates(clamp, bodies, lying, draw):
    jaw, body = clamp[1], bodies[1]
    twin, twin_body = replace(jaw, name="twin"), replace(body, name="twin")
    poses = {"jaw": lying["jaw"], "twin": Pose.from_translation(-0.14, 0, 0) @ lying["jaw"]}
    # The network takes both for one of them.
    boxes = [("jaw", around(jaw, pose), 0.8) for pose in poses.values()]
    finder = finder_of((jaw, twin), (body, twin_body), boxes)
    found = finder.find(draw((jaw, twin), poses), ["jaw", "twin"])
    first = {each.part: each.camera_from_body.translation[0] for each in reversed(found)}
    places = sorted(pose.translation[0] for pose in poses.values())
    assert sorted(first.values()) == pytest.approx(places, abs=0.003)
    alone = finder.find(draw((jaw, twin), poses), ["twin"])
    assert sorted(e.camera_from_body.translation[0] for e in alone) == pytest.approx(
        places, abs=0.003
    )


def test_without_depth_the_network_speaks_alone(clamp, bodies, lying, draw):
    finder = finder_of(clamp, bodies, boxes_of(clamp, lying))
    found = finder.find(replace(draw(clamp, lying), depth=None), ["jaw"])
    assert [(each.part, each.is_refined) for each in found] == [("jaw", False)]
    network = Network(("jaw",), ())
    assert guided(network, bodies, RgbdCamera(AZURE_KINECT_720P)) is network
    assert isinstance(guided(network, bodies, CAMERA), GuidedFinder)


def test_the_same_frame_gives_the_same_poses(clamp, bodies, lying, draw):
    frame, finder = draw(clamp, lying), finder_of(clamp, bodies, boxes_of(clamp, lying))
    once, again = finder.find(frame, ["base"]), finder.find(frame, ["base"])
    assert np.array_equal(once[0].camera_from_body.matrix, again[0].camera_from_body.matrix)


def joined(base: Part) -> dict[str, Pose]:
    """Base and jaw as their link has them, upright on the bench."""
    link = next(link for state in ASSET.states for link in state.links if link.child == "jaw")
    pose = on_bench(base, [2.356, 0.0, 0.0], -0.05, 0.03)
    return {"base": pose, "jaw": pose @ link.parent_from_child}
