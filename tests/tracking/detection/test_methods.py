"""`yolov8pose` by its name: the network is taken from the asset's bundle."""

from dataclasses import replace

import pytest
from fake_network import ASSET, PARTS, POSES, RGBD, frame, output, write_detector

from snapfit.models.errors import DetectorError
from snapfit.tracking.benchmark import versions
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.result import Status


def make(method, folder):
    return create_tracker(method, PARTS, RGBD, asset=replace(ASSET, directory=folder))


def test_the_bundles_network_is_used(tmp_path):
    write_detector(tmp_path)
    tracker = make("yolov8pose", tmp_path)
    tracker.start(frame(), POSES)
    result = tracker.track(frame())
    assert [each.status for each in result.parts] == [Status.TRACKED] * 2
    assert result.parts[0].camera_from_body.distance_to(POSES[PARTS[0].name]) < 1e-4


def test_with_depth_the_distance_is_measured(tmp_path):
    rows = output()
    for row in (6, 7):
        middle = rows[0, row::3, 10].mean()
        rows[0, row::3, 10] = middle + 1.06 * (rows[0, row::3, 10] - middle)
    rows[0, 2:4, 10] *= 1.06
    write_detector(tmp_path, rows)
    true = POSES[PARTS[0].name].translation[2]
    color, depth = (
        make(method, tmp_path).track(frame()).parts[0].camera_from_body.translation[2]
        for method in ("yolov8pose", "yolov8pose+depth")
    )
    assert abs(color - true) > 0.02
    assert abs(depth - true) < 0.004


def test_the_ablations_network_lies_in_a_folder_of_its_own(tmp_path):
    write_detector(tmp_path)
    with pytest.raises(DetectorError, match=r"without-assembled/detector\.json: is missing"):
        make("yolov8pose-apart", tmp_path)
    write_detector(tmp_path / "without-assembled")
    assert make("yolov8pose-apart", tmp_path).track(frame()).parts[0].status is Status.TRACKED


def test_a_bundle_without_a_network_is_told(tmp_path):
    with pytest.raises(DetectorError, match=r"detector\.json: is missing"):
        make("yolov8pose", tmp_path)


def test_loose_parts_have_no_network():
    with pytest.raises(TrackingError, match="yolov8pose needs the network in an asset's bundle"):
        create_tracker("yolov8pose", PARTS, RGBD)


def test_runs_of_trackers_stand_when_detection_changes():
    """A benchmark's finished runs depend on what their methods load, and on nothing else."""
    shared = {path.as_posix() for path in versions.imported_files()}
    assert not any("tracking/detection" in path for path in shared)
    own = versions._module_version("snapfit.tracking.detection.frame_by_frame")
    assert versions._module_version("snapfit.tracking.detection.pnp") != own
    assert versions.code_version("yolov8pose") != versions.code_version("yolov8pose+depth")
