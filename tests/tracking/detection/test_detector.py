"""The whole of a detector on networks whose answer is known."""

import numpy as np
import pytest
from fake_network import (
    CAMERA,
    MODELS,
    N_ANCHORS,
    PARTS,
    POSES,
    RGBD,
    frame,
    output,
    write_detector,
)

from snapfit.models.asset import find_asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import DetectorError
from snapfit.tracking.detection.detector import Detector
from snapfit.tracking.detection.frame_by_frame import FrameByFrame
from snapfit.tracking.detection.letterbox import Letterbox
from snapfit.tracking.detection.parameters import (
    CandidateParameters,
    DetectorParameters,
    RangeParameters,
)
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.finding.finder import Finder
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import Status

FIRST, SECOND = (part.name for part in PARTS)


def make(folder, rows=None, parts=PARTS, **settings):
    return Detector(write_detector(folder, rows), parts, RGBD, DetectorParameters(**settings))


def test_poses_come_back_from_perfect_keypoints(tmp_path):
    found = make(tmp_path).detect(frame())
    assert [each.part for each in found.found] == [FIRST, SECOND]
    assert found.rejected == {}
    assert found.frame == "000000"
    assert found.duration_ms > 0
    for each in found.found:
        true = POSES[each.part]
        assert each.camera_from_body.distance_to(true) < 1e-4
        assert each.camera_from_body.angle_to(true) < 1e-3
        assert each.is_inlier.all()
        assert each.error_px < 0.01
        assert each.confidence == pytest.approx(each.score)
    pixels = CAMERA.project(POSES[FIRST].transform(MODELS[0].points))
    np.testing.assert_allclose(found.best()[FIRST].keypoints_px, pixels, atol=1e-3)
    outline = CAMERA.project(POSES[FIRST].transform(PARTS[0].mesh.vertices))
    expected = [*outline.min(axis=0), *outline.max(axis=0)]
    np.testing.assert_allclose(found.best()[FIRST].box_px, expected, atol=1e-3)


def test_outliers_among_the_keypoints_are_found_out(tmp_path):
    rows = output()
    rng = np.random.default_rng(3)
    for k in rng.choice(17, 5, replace=False):
        rows[0, 6 + 3 * k : 8 + 3 * k, 10] += rng.uniform(15, 40, 2)
    found = make(tmp_path, rows).detect(frame()).best()[FIRST]
    assert found.is_inlier.sum() == 12
    assert found.camera_from_body.distance_to(POSES[FIRST]) < 2e-4
    assert found.confidence == pytest.approx(0.9 * 12 / 17, rel=1e-4)


def test_of_overlapping_candidates_the_best_is_kept_and_two_apart_both(tmp_path):
    rows = output()
    rows[0, :, 11] = rows[0, :, 10]
    rows[0, 4, 11] = 0.6
    rows[0, :, 30] = rows[0, :, 10]
    rows[0, 0, 30] += 120
    rows[0, 6::3, 30] += 120
    rows[0, 4, 30] = 0.5
    found = make(tmp_path, rows).detect(frame()).found
    assert [(each.part, round(each.score, 2)) for each in found] == [
        (FIRST, 0.9),
        (SECOND, 0.8),
        (FIRST, 0.5),
    ]
    few = CandidateParameters(most_instances=1)
    found = make(tmp_path, rows, candidates=few).detect(frame()).found
    assert [each.part for each in found] == [FIRST, SECOND]


def test_only_wanted_parts_are_found(tmp_path):
    detector = make(tmp_path, parts=PARTS[1:])
    assert detector.names == (SECOND,)
    assert [each.part for each in detector.detect(frame()).found] == [SECOND]


def test_a_network_for_other_parts_is_refused(tmp_path):
    others = find_asset("liftpod").tracked_parts
    with pytest.raises(TrackingError, match="finds base, jaw: none of them is to be found"):
        make(tmp_path, parts=others)


def test_numbers_that_are_none_are_left_out_and_counted(tmp_path):
    rows = output()
    rows[0, 20, 10] = np.nan
    rows[0, :, 40] = np.inf
    found = make(tmp_path, rows).detect(frame())
    assert [each.part for each in found.found] == [SECOND]
    assert found.rejected == {"not_finite": 2}


def test_an_output_of_nothing_but_nan_finds_nothing(tmp_path):
    found = make(tmp_path, np.full_like(output(), np.nan)).detect(frame())
    assert found.found == ()
    assert found.rejected == {"not_finite": N_ANCHORS}


def test_keypoints_that_agree_on_nothing_are_counted(tmp_path):
    rows = output()
    rng = np.random.default_rng(1)
    for row in (6, 7):
        rows[0, row::3, 10] = rng.uniform(0, 192, 17)
    found = make(tmp_path, rows).detect(frame())
    assert [each.part for each in found.found] == [SECOND]
    assert sum(found.rejected.values()) == 1


def test_keypoints_outside_of_the_image_are_not_used(tmp_path):
    rows = output()
    rows[0, 8:47:3, 10] = 0.05
    found = make(tmp_path, rows).detect(frame())
    assert found.rejected == {"few_keypoints": 1}


def test_depth_fixes_the_distance(tmp_path):
    """Keypoints and box of a part seen 6 % larger: nearer by them, but not by measured depth."""
    rows = output()
    center = rows[0, 6::3, 10].mean(), rows[0, 7::3, 10].mean()
    for row, middle in zip((6, 7), center, strict=True):
        rows[0, row::3, 10] = middle + 1.06 * (rows[0, row::3, 10] - middle)
    rows[0, 2:4, 10] *= 1.06
    true = POSES[FIRST]
    colour = make(tmp_path, rows).detect(frame()).best()[FIRST]
    assert not colour.is_ranged
    assert abs(colour.camera_from_body.translation[2] - true.translation[2]) > 0.02
    detector = make(tmp_path, rows, range=RangeParameters())
    ranged = detector.detect(frame()).best()[FIRST]
    assert ranged.is_ranged
    assert abs(ranged.camera_from_body.translation[2] - true.translation[2]) < 0.004
    assert ranged.camera_from_body.angle_to(colour.camera_from_body) < 1e-9


def test_the_box_places_a_part_whose_keypoints_shrank(tmp_path):
    """Unsure keypoints are said near to the middle: PnP alone puts the part too far away."""
    rows = output()
    center = rows[0, 6::3, 10].mean(), rows[0, 7::3, 10].mean()
    for row, middle in zip((6, 7), center, strict=True):
        rows[0, row::3, 10] = middle + 0.7 * (rows[0, row::3, 10] - middle)
    true = POSES[FIRST].translation[2]
    alone = make(tmp_path, rows, box=None).detect(frame()).best()[FIRST]
    assert alone.camera_from_body.translation[2] > 1.3 * true
    placed = make(tmp_path, rows).detect(frame()).best()[FIRST]
    assert abs(placed.camera_from_body.translation[2] - true) < 0.02
    assert placed.camera_from_body.angle_to(alone.camera_from_body) < 1e-9


def test_without_depth_of_the_part_the_distance_is_that_of_colour(tmp_path):
    detector = make(tmp_path, range=RangeParameters())
    shown = frame()
    nothing = Frame("a", 0, shown.color, np.zeros_like(shown.depth))
    assert not any(each.is_ranged for each in detector.detect(nothing).found)
    assert not any(each.is_ranged for each in detector.detect(frame(2.0)).found)
    absent = Frame("a", 0, shown.color, None)
    assert len(detector.detect(absent).found) == 2


def test_a_hand_before_half_of_the_part_does_not_pull_it_nearer(tmp_path):
    shown = frame()
    pixels = CAMERA.project(POSES[FIRST].transform(PARTS[0].mesh.vertices))
    middle = round(float(pixels[:, 0].mean()))
    shown.depth[:, :middle] = np.minimum(shown.depth[:, :middle], 480)
    ranged = make(tmp_path, range=RangeParameters()).detect(shown).best()[FIRST]
    assert ranged.is_ranged
    assert ranged.camera_from_body.distance_to(POSES[FIRST]) < 0.003


def test_an_image_of_another_size_is_refused(tmp_path):
    small = np.zeros((100, 100, 3), dtype=np.uint8)
    with pytest.raises(FrameError, match="colour image"):
        make(tmp_path).detect(Frame("000007", 0, small))


def test_the_size_of_a_free_input_follows_the_image(tmp_path):
    folder = write_detector(tmp_path, free=True)
    assert Detector(folder, PARTS, RGBD).input_size == (320, 192)
    square = CAMERA.__class__(640, 480, 500.0, 500.0, 320.0, 240.0)
    assert Detector(folder, PARTS, RgbdCamera(square)).input_size == (320, 256)


def test_as_a_method_every_frame_stands_for_itself(tmp_path):
    third = find_asset("hobby-corner-clamp").tracked_parts[2].name
    method = FrameByFrame((FIRST, SECOND, third), RGBD, make(tmp_path))
    method.start(frame(), POSES)
    method.set_state("assembled")
    result = method.track(frame(name="000003"))
    assert result.frame == "000003"
    status = [each.status for each in result.parts]
    assert status == [Status.TRACKED, Status.TRACKED, Status.SEARCHING]
    assert result.parts[0].camera_from_body.distance_to(POSES[FIRST]) < 1e-4
    assert result.parts[2].camera_from_body is None
    assert result.parts[2].confidence == 0
    with pytest.raises(TrackingError, match="no part 'lid'"):
        method.start(frame(), {"lid": POSES[FIRST]})
    with pytest.raises(TrackingError):
        method.track(None)


def test_a_method_for_parts_that_cannot_be_found_is_refused(tmp_path):
    with pytest.raises(TrackingError, match="none is wanted"):
        FrameByFrame(("lid",), RGBD, make(tmp_path))


def test_as_a_finder_it_gives_hypotheses_of_what_is_wanted(tmp_path):
    detector: Finder = make(tmp_path)
    both = detector.find(frame(), {FIRST, SECOND})
    assert [each.part for each in both] == [FIRST, SECOND]
    assert both[0].score == pytest.approx(0.9)
    assert both[0].camera_from_body.distance_to(POSES[FIRST]) < 1e-4
    assert [each.part for each in detector.find(frame(), [SECOND])] == [SECOND]
    with pytest.raises(TrackingError, match="finds base, jaw, not 'lid'"):
        detector.find(frame(), {"lid"})


def test_a_network_that_breaks_while_it_runs_is_told(tmp_path):
    detector = make(tmp_path)
    detector.input_size = (64, 64)
    detector._letterbox = Letterbox(CAMERA.width, CAMERA.height, 64, 64)
    with pytest.raises(DetectorError, match="does not run"):
        detector.detect(frame())
    with pytest.raises(TrackingError, match="does not run"):
        detector.find(frame(), {FIRST})
