"""Trackers with a detector beside, by their names: which detector, which rule, what delay."""

from contextlib import suppress
from dataclasses import replace

import pytest
from fake_network import ASSET, PARTS, RGBD, write_detector

from snapfit.models.errors import DetectorError
from snapfit.tracking.benchmark import roster, versions
from snapfit.tracking.benchmark.weights import weights
from snapfit.tracking.detection import detector
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding import reinitialised
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.finding.paper_reinit import PaperReinitialisation
from snapfit.tracking.finding.reinitialised import DelayFrames, delay_frames
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.method import LATENCIES, Latency
from snapfit.tracking.methods import create_tracker

NETWORK = ("gbot+reinit", "gbot+reinit-cold", "gbot+reinit-paper")
GEOMETRIC = ("gbot+reinit-geometric", "gbot+reinit-geometric-cold")


def make(method, folder, **more):
    return create_tracker(method, PARTS, RGBD, asset=replace(ASSET, directory=folder), **more)


@pytest.mark.parametrize(
    ("latency_s", "rate_hz", "frames"),
    [(0.06, 30.0, 2), (0.06, 60.0, 4), (0.001, 30.0, 1), (0.0, 30.0, 1), (0.1, 30.0, 3)],
)
def test_a_detection_comes_as_many_frames_later_as_it_took(latency_s, rate_hz, frames) -> None:
    assert delay_frames(latency_s, rate_hz) == frames


def test_a_look_for_more_parts_takes_longer() -> None:
    delay = DelayFrames(Latency(0.1, 0.05), 30.0)
    assert [delay(n) for n in (1, 2, 8)] == [5, 6, 15]


@pytest.mark.parametrize("rate_hz", [30.0, 15.0])
def test_the_delay_follows_the_frame_rate(tmp_path, monkeypatch, rate_hz) -> None:
    delays = []
    real = reinitialised.DelayedLookout
    monkeypatch.setattr(
        reinitialised,
        "DelayedLookout",
        lambda finder, frames: delays.append(frames) or real(finder, frames),
    )
    write_detector(tmp_path)
    assert isinstance(make("gbot+reinit", tmp_path, frame_rate_hz=rate_hz), SelfStartingTracker)
    kinds = ["network"]
    with suppress(TrackingError):
        open3d()
        kinds = ["network", "geometric"]
    assert delays == [DelayFrames(LATENCIES[kind], rate_hz) for kind in kinds]


@pytest.mark.parametrize(("method", "uses_depth"), [("gbot+reinit", True), (NETWORK[2], False)])
def test_only_the_papers_rule_looks_at_colour_alone(
    tmp_path, monkeypatch, method, uses_depth
) -> None:
    made = []
    real = detector.Detector

    def spy(*arguments):
        made.append(arguments[-1])
        return real(*arguments)

    monkeypatch.setattr(detector, "Detector", spy)
    write_detector(tmp_path)
    tracker = make(method, tmp_path)
    assert isinstance(tracker, PaperReinitialisation) == (not uses_depth)
    assert [settings.range is not None for settings in made] == [uses_depth]


@pytest.mark.parametrize("method", NETWORK)
def test_a_bundle_without_a_network_is_told(tmp_path, method) -> None:
    with pytest.raises(DetectorError, match=r"detector\.json: is missing"):
        make(method, tmp_path)


def test_without_a_network_shape_is_enough(tmp_path) -> None:
    try:
        open3d()
    except TrackingError as error:
        pytest.skip(str(error))
    assert isinstance(make(GEOMETRIC[0], tmp_path), SelfStartingTracker)


def test_loose_parts_have_no_detector() -> None:
    with pytest.raises(TrackingError, match=r"gbot\+reinit looks for the parts of an asset"):
        create_tracker("gbot+reinit", PARTS, RGBD)


def test_cold_rows_differ_in_nothing_but_the_start() -> None:
    for warm, cold in (NETWORK[:2], GEOMETRIC):
        assert roster.starts_cold(cold)
        assert not roster.starts_cold(warm)
        named = {"summary": "", "is_cold": False}
        assert replace(roster.entry(cold), **named) == replace(roster.entry(warm), **named)


def test_weights_are_those_of_the_assets_own_network(tmp_path) -> None:
    asset = replace(ASSET, directory=tmp_path)
    for method in NETWORK:
        names = [path.relative_to(tmp_path).as_posix() for path in weights(method, asset)]
        assert names == ["detector.onnx", "detector.json"]
    apart = weights("yolov8pose-apart", asset)
    assert {path.parent.name for path in apart} == {"without-assembled"}
    for method in ("gbot", *GEOMETRIC):
        assert weights(method, asset) == ()


def test_runs_depend_on_the_detector_that_is_used_and_on_no_other() -> None:
    shared = {path.as_posix() for path in versions.imported_files()}
    assert not any("/finding/" in path or "/detector/" in path for path in shared)
    reached = {
        method: {
            path.name
            for module in roster.entry(method).modules
            for path in versions._reached([versions._file_of(module)])
        }
        for method in ("gbot+reinit", "gbot+reinit-geometric")
    }
    assert {"self_starting.py", "detector.py", "pnp.py"} <= reached["gbot+reinit"]
    assert {"self_starting.py", "geometric.py", "clusters.py"} <= reached["gbot+reinit-geometric"]
    # Shape alone takes turns with the network.
    assert "geometric.py" in reached["gbot+reinit"]
    assert "pnp.py" not in reached["gbot+reinit-geometric"]
    assert len({versions.code_version(method) for method in (*NETWORK, *GEOMETRIC)}) == 5
