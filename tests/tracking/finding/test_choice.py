"""Which detector a station gets."""

from pathlib import Path
from typing import get_args

import pytest

from snapfit.models.detector.card import ONNX_NAME
from snapfit.tracking.detection.providers import PROVIDERS
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding import choice
from snapfit.tracking.finding.choice import chosen_detector
from snapfit.tracking.finding.create import DETECTORS
from snapfit.tracking.finding.names import DetectorWish, ProviderName


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    (tmp_path / ONNX_NAME).write_bytes(b"not looked into")
    return tmp_path


@pytest.fixture
def _has_open3d(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "open3d", lambda: None)


def test_the_assets_own_network_comes_first(bundle: Path) -> None:
    assert chosen_detector("auto", bundle, has_depth=True) == "network"
    assert chosen_detector("auto", bundle, has_depth=False) == "network"


@pytest.mark.usefixtures("_has_open3d")
def test_without_a_network_it_is_the_shape(tmp_path: Path) -> None:
    assert chosen_detector("auto", tmp_path, has_depth=True) == "geometric"
    assert chosen_detector("auto", None, has_depth=True) == "geometric"


def test_without_depth_it_is_nothing_and_the_log_says_why(tmp_path: Path, caplog) -> None:
    assert chosen_detector("auto", tmp_path, has_depth=False) is None
    assert "has no detector.onnx" in caplog.text
    assert "no depth camera" in caplog.text


def test_without_open3d_it_is_nothing_and_the_log_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog
) -> None:
    def absent() -> None:
        raise TrackingError("no Open3D: `apt-get install libgl1`")

    monkeypatch.setattr(choice, "open3d", absent)
    assert chosen_detector("auto", tmp_path, has_depth=True) is None
    assert "apt-get install libgl1" in caplog.text


def test_what_is_named_is_taken_and_not_replaced(bundle: Path, caplog) -> None:
    assert chosen_detector("geometric", bundle, has_depth=False) == "geometric"
    assert chosen_detector("network", None, has_depth=True) == "network"
    assert chosen_detector("none", bundle, has_depth=True) is None
    assert caplog.text == ""


def test_settings_and_tracking_know_the_same_names() -> None:
    assert {*DETECTORS, "auto", "none"} == set(get_args(DetectorWish))
    assert set(PROVIDERS) == set(get_args(ProviderName))
