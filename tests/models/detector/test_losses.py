"""Assignment and losses on known answers: perfect ones cost nothing, wrong ones are told apart."""

import math

import pytest

torch = pytest.importorskip("torch", reason="PyTorch is not installed: snapfit[train]")

from snapfit.models.detector.assigner import assign
from snapfit.models.detector.boxes import complete_iou, iou, scale
from snapfit.models.detector.losses import losses
from snapfit.models.detector.network import KEYPOINT_GAIN, RawOutput, anchor_grid
from snapfit.models.detector.targets import Targets

N_CLASSES, N_KEYPOINTS = 3, 4
ROWS, COLUMNS = 12, 16


def grid():
    shapes = [(ROWS // k, COLUMNS // k) for k in (1, 2, 4)]
    return anchor_grid(shapes, torch.device("cpu"))


def targets(boxes, classes, ignored=None):
    boxes = torch.tensor(boxes, dtype=torch.float32)[None]
    corners = [boxes[..., [0, 1]], boxes[..., [2, 1]], boxes[..., [2, 3]], boxes[..., [0, 3]]]
    points = torch.stack(corners, dim=2)
    keypoints = torch.cat([points, torch.ones_like(points[..., :1])], dim=-1)
    classes = torch.tensor(classes)[None]
    ignored = torch.tensor(ignored or [False] * classes.shape[1])[None]
    return Targets(classes, boxes, keypoints, ignored)


def perfect(wanted, sure=8.0):
    """What a network would say that knows it all."""
    anchors, strides = grid()
    count = len(anchors)
    sides = torch.full((1, count, 4, 16), -20.0)
    classes = torch.full((1, count, N_CLASSES), -sure)
    keypoints = torch.zeros((1, count, N_KEYPOINTS, 3))
    for k in range(wanted.classes.shape[1]):
        box = wanted.boxes[0, k]
        inside = ((anchors > box[:2]) & (anchors < box[2:])).all(-1)
        distances = torch.cat([anchors - box[:2], box[2:] - anchors], dim=-1) / strides[:, None]
        lower = distances.clamp(0, 14).long()
        share = distances - lower
        logs = torch.full((count, 4, 16), -20.0)
        logs.scatter_(2, lower[..., None], (1 - share).clamp(min=1e-9).log()[..., None])
        logs.scatter_(2, lower[..., None] + 1, share.clamp(min=1e-9).log()[..., None])
        sides[0, inside] = logs[inside]
        classes[0, inside, wanted.classes[0, k]] = sure
        offsets = wanted.keypoints[0, k, None, :, :2] - anchors[:, None]
        reach = KEYPOINT_GAIN * strides[:, None, None]
        keypoints[0, inside, :, :2] = (offsets / reach)[inside]
        keypoints[0, inside, :, 2] = sure
    return RawOutput(sides, classes, keypoints, anchors, strides)


def sure_of_few(wanted):
    """Perfect, and of each part only those anchors speak that are asked for it."""
    raw = perfect(wanted)
    given = assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted)
    raw.classes[0, ~given.is_positive[0]] = -8.0
    return raw


BOXES = [[10.0, 12.0, 42.0, 36.0], [64.0, 20.0, 100.0, 70.0]]


def test_overlap_of_known_boxes():
    a = torch.tensor([0.0, 0.0, 10.0, 10.0])
    b = torch.tensor([[0.0, 0.0, 10.0, 10.0], [5.0, 0.0, 15.0, 10.0], [20.0, 0.0, 30.0, 10.0]])
    assert iou(a, b).tolist() == pytest.approx([1, 1 / 3, 0], abs=1e-6)
    found = complete_iou(a, b).tolist()
    # Distance of the centres over the diagonal of the box around both, squared.
    assert found == pytest.approx([1, 1 / 3 - 25 / 325, -400 / 1000], abs=1e-6)
    assert float(complete_iou(a, torch.tensor([0.0, 0.0, 20.0, 5.0]))) < float(
        iou(a, torch.tensor([0.0, 0.0, 20.0, 5.0]))
    )
    assert scale(torch.tensor([0.0, 0.0, 8.0, 8.0])).item() == pytest.approx(8)


def test_the_best_anchors_get_the_part():
    wanted = targets(BOXES, [0, 2])
    raw = perfect(wanted)
    given = assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted)
    for k, box in enumerate(wanted.boxes[0]):
        mine = given.is_positive[0] & (given.part[0] == k)
        assert 1 <= int(mine.sum()) <= 10
        assert ((raw.anchors[mine] > box[:2]) & (raw.anchors[mine] < box[2:])).all()
        assert float(given.quality[0, mine].max()) == pytest.approx(1, abs=0.01)
    assert not given.quality[0, ~given.is_positive[0]].any()


def test_a_part_between_all_anchors_gets_one_all_the_same():
    wanted = targets([[9.0, 9.0, 12.0, 15.0]], [1])
    raw = perfect(wanted)
    given = assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted)
    assert int(given.is_positive.sum()) >= 1


def test_parts_in_doubt_and_empty_places_get_none():
    wanted = targets(BOXES, [0, -1])
    raw = perfect(targets(BOXES, [0, 2]))
    given = assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted)
    assert (given.part[given.is_positive] == 0).all()
    wanted = targets(BOXES, [0, 2], [True, True])
    assert not assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted).is_positive.any()


def test_of_two_parts_that_want_an_anchor_the_one_it_overlaps_more_gets_it():
    wanted = targets([[16.0, 16.0, 32.0, 30.0], [16.0, 16.0, 32.0, 32.0]], [0, 1])
    raw = perfect(targets([[16.0, 16.0, 32.0, 32.0]], [1]))
    given = assign(torch.full_like(raw.classes, 0.5), raw.boxes(), raw.anchors, wanted)
    assert int(given.is_positive.sum()) == 5
    assert (given.part[given.is_positive] == 1).all()


def test_a_perfect_answer_costs_next_to_nothing():
    wanted = targets(BOXES, [0, 2])
    found = losses(sure_of_few(wanted), wanted).values()
    assert found["box"] < 0.02
    assert found["keypoints"] < 0.02
    assert found["presence"] < 0.01
    assert found["classes"] < 0.2
    assert found["total"] == pytest.approx(sum(found[name] for name in found if name != "total"))


def test_each_mistake_shows_in_its_own_loss():
    wanted = targets(BOXES, [0, 2])
    right = losses(sure_of_few(wanted), wanted).values()
    raw = sure_of_few(wanted)
    raw.keypoints[..., 0] += 0.5
    moved = losses(raw, wanted).values()
    assert moved["keypoints"] > right["keypoints"] + 1
    assert moved["box"] == pytest.approx(right["box"])
    raw = sure_of_few(wanted)
    raw.keypoints[..., 2] *= -1
    assert losses(raw, wanted).values()["presence"] > 5
    raw = sure_of_few(wanted)
    raw.classes[0, 150, 1] = 8.0
    assert losses(raw, wanted).values()["classes"] > right["classes"] + 0.1


def test_a_keypoint_outside_of_the_image_has_no_place():
    wanted = targets(BOXES, [0, 2])
    right = losses(perfect(wanted), wanted).values()
    wanted.keypoints[..., 0, 2] = 0
    wanted.keypoints[..., 0, :2] = 1e4
    found = losses(perfect(targets(BOXES, [0, 2])), wanted).values()
    assert found["keypoints"] == pytest.approx(right["keypoints"], abs=1e-3)
    assert found["presence"] > 1


def test_the_keypoint_loss_is_a_distance_in_sizes_of_the_part():
    wanted = targets([[16.0, 16.0, 48.0, 48.0]], [0])
    raw = perfect(wanted)
    offset_px = 3.2
    raw.keypoints[..., 1] += offset_px / (KEYPOINT_GAIN * raw.strides[:, None])
    expected = 12 * (math.hypot(offset_px / 32, 1e-3) - 1e-3)
    quality = assign(raw.classes.sigmoid(), raw.boxes(), raw.anchors, wanted).quality.sum()
    share = float(quality / quality.clamp(min=1))
    assert losses(raw, wanted).values()["keypoints"] == pytest.approx(expected * share, rel=1e-3)


def test_finding_a_part_that_is_hardly_seen_is_no_mistake():
    raw = sure_of_few(targets(BOXES, [0, 2]))
    ignored = losses(raw, targets(BOXES, [0, 2], [False, True])).values()["classes"]
    absent = losses(raw, targets(BOXES[:1], [0])).values()["classes"]
    assert ignored < 0.2
    assert absent > ignored + 1


def test_an_image_without_parts_teaches_that_there_are_none():
    raw = perfect(targets(BOXES, [0, 2]))
    found = losses(raw, targets([[0.0, 0.0, 0.0, 0.0]], [-1])).values()
    assert found["classes"] > 1
    assert all(found[name] == 0 for name in ("box", "distribution", "keypoints", "presence"))
