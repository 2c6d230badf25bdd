"""A station whose source brings no poses: what finds its parts, and what is refused."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree, ignore_patterns

import numpy as np
import pytest

pytest.importorskip("onnx", reason="onnx is not installed: snapfit[test]")

import fake_network
from found_scene import CAMERA, FOUND, POSES, write_bundle, write_recording

from snapfit.models.asset import find_asset
from snapfit.models.errors import DetectorError, SnapfitError
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.server.open_pipeline import chosen_method, open_pipeline
from snapfit.server.pipeline import Pipeline
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.errors import SourceError, TrackingError

ASSET = find_asset("hobby-corner-clamp")


def opened(source: Path, asset: Path | str, **given: str) -> Pipeline:
    spec = WorkerSpec(
        station="bench",
        source=str(source),
        asset=str(asset),
        boot_id="",
        wall_minus_monotonic_ns=0,
        poses_segment="",
        pictures_segment="",
        **{"method": "icg", "detector": "auto", **given},
    )
    return open_pipeline(spec, lambda _text, _share: None)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("recording") / "bench")


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    return write_bundle(tmp_path / "hobby-corner-clamp")


def test_the_bundles_network_is_taken_by_itself(recording: Path, bundle: Path) -> None:
    pipeline = opened(recording, bundle, method="auto")
    try:
        assert (pipeline.method, pipeline.detector, pipeline.provider) == ("gbot", "network", "cpu")
        assert pipeline.tracker is pipeline.finding
    finally:
        pipeline.close()


def test_with_none_the_tracker_starts_from_the_sources_poses(tmp_path: Path, bundle: Path) -> None:
    pipeline = opened(write_recording(tmp_path / "bench", POSES), bundle, detector="none")
    try:
        assert (pipeline.finding, pipeline.detector, pipeline.provider) == (None, None, None)
        assert set(pipeline.source.initial_poses) == set(FOUND)
    finally:
        pipeline.close()


def cut(bundle: Path) -> None:
    (bundle / "detector.onnx").write_bytes(b"no network at all")


def missing(bundle: Path) -> None:
    (bundle / "detector.onnx").unlink()


def without_card(bundle: Path) -> None:
    (bundle / "detector.json").unlink()


def flat(bundle: Path) -> None:
    fake_network.write_network(bundle, fake_network.output()[0])


def one_class_too_many(bundle: Path) -> None:
    rows = fake_network.output()
    more = np.concatenate([rows, np.zeros((1, 1, rows.shape[2]), dtype=np.float32)], axis=1)
    fake_network.write_network(bundle, more)


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (cut, "is no ONNX file that runs"),
        (missing, "is missing: snapfit train hobby-corner-clamp makes one"),
        (without_card, "is missing: it says what the classes"),
        (flat, "is it a pose network in the layout of YOLOv8"),
        (one_class_too_many, "with as many keypoints it would have 3 classes"),
    ],
)
def test_a_network_that_cannot_be_used_is_refused_and_named(
    recording: Path, bundle: Path, damage, problem: str
) -> None:
    damage(bundle)
    with pytest.raises(DetectorError) as caught:
        opened(recording, bundle, detector="network")
    assert problem in str(caught.value)
    assert str(bundle) in str(caught.value)


def test_a_damaged_network_is_not_passed_over(recording: Path, bundle: Path) -> None:
    cut(bundle)
    with pytest.raises(DetectorError, match="is no ONNX file that runs"):
        opened(recording, bundle, detector="auto")


def colour_alone(folder: Path) -> Path:
    camera = type(CAMERA)(CAMERA.color)
    with SequenceWriter(folder, camera, asset=ASSET.name, initial_poses={}) as writer:
        writer.write("000000", np.zeros((camera.color.height, camera.color.width, 3), np.uint8))
    return folder


@pytest.mark.parametrize(
    ("detector", "kind", "problem"),
    [
        ("none", SourceError, "no part has an initial pose to start from"),
        ("auto", SourceError, r"choose a detector \(station.detector\)"),
        ("geometric", TrackingError, "needs a depth camera"),
    ],
)
def test_a_source_whose_parts_nobody_finds_is_refused(
    tmp_path: Path, detector: str, kind: type[SnapfitError], problem: str
) -> None:
    unlearnt = tmp_path / ASSET.name
    copytree(ASSET.directory, unlearnt, ignore=ignore_patterns("detector.*", "without-*"))
    with pytest.raises(kind, match=problem):
        opened(colour_alone(tmp_path / "colour"), str(unlearnt), detector=detector)


def test_a_method_that_finds_the_parts_itself_needs_no_detector(
    recording: Path, bundle: Path
) -> None:
    pipeline = opened(recording, bundle, method="yolov8pose")
    assert pipeline.finding is None
    pipeline.close()
    with pytest.raises(TrackingError, match="it needs no detector beside"):
        opened(recording, bundle, method="yolov8pose", detector="network")


def test_the_method_is_chosen_by_what_is_known() -> None:
    stateless = type(ASSET)(ASSET.name, "", "", ASSET.directory, ASSET.parts)
    other = type(ASSET.parts[0])("other", ASSET.parts[0].mesh)
    assert chosen_method("auto", ASSET.tracked_parts, ASSET) == "gbot"
    assert chosen_method("auto", ASSET.tracked_parts, None) == "icg"
    assert chosen_method("auto", ASSET.tracked_parts, stateless) == "icg"
    assert chosen_method("auto", [*ASSET.tracked_parts, other], ASSET) == "icg"
    assert chosen_method("srt3d", ASSET.tracked_parts, ASSET) == "srt3d"
