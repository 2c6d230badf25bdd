"""What each driver makes of its library's answers: places, units, distortion, sizes."""

from __future__ import annotations

import importlib
import sys
from contextlib import closing
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "stand_ins"))

from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import parse_address
from snapfit.tracking.sources.azure_kinect import AzureKinect
from snapfit.tracking.sources.driver import CameraDriver, LensedCamera
from snapfit.tracking.sources.oak import Oak
from snapfit.tracking.sources.orbbec import Orbbec
from snapfit.tracking.sources.realsense import RealSense


def library(name: str) -> ModuleType:
    sys.modules.pop(name, None)
    return importlib.import_module(name)


def opened(driver: Any, text: str) -> tuple[CameraDriver, LensedCamera]:
    address = parse_address(text)
    assert address is not None
    made = driver(address)
    return made, made.open()


def test_realsense_extrinsics_are_columns_and_its_lens_is_opencvs() -> None:
    rs = library("pyrealsense2")
    driver, lensed = opened(RealSense, "realsense:?width=640&height=480&fps=15")
    with closing(driver):
        wanted = np.array([[0, -1, 0, 0.015], [1, 0, 0, 0.001], [0, 0, 1, -0.002], [0, 0, 0, 1]])
        assert np.allclose(lensed.color_from_depth.matrix, wanted)
        assert lensed.depth_scale_m == 0.00025
        assert lensed.color_distortion == tuple(rs.COEFFICIENTS)
        assert rs.asked["color"] == (640, 480, "bgr8", 15)
        assert rs.asked["depth"] == (640, 480, "z16", 15)
        assert lensed.name == "Stand-in D435 0815"
        driver.close()
        rs.distortion.name = "kannala_brandt4"
        with pytest.raises(SourceError, match="kannala_brandt4 is not supported"):
            driver.open()


def test_a_kinects_place_of_depth_comes_from_four_points_in_millimetres() -> None:
    k4a = library("pyk4a")
    driver, lensed = opened(AzureKinect, "kinect:0815")
    with closing(driver):
        matrix = lensed.color_from_depth.matrix
        assert np.allclose(matrix[:3, :3], k4a.TURN, atol=1e-3)
        assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.allclose(matrix[:3, 3], k4a.SHIFT_MM / 1000, atol=1e-4)
        assert lensed.color_distortion == tuple(k4a.COEFFICIENTS)
        assert (lensed.color.fy, lensed.color.cx) == (601.0, 318.5)
        images = driver.read(0.1)
        assert images is not None
        assert images.color.shape == (720, 1280, 3)
    with pytest.raises(SourceError, match="1920x1080"):
        opened(AzureKinect, "kinect:?width=640&height=480")


def test_orbbec_depth_is_brought_to_millimetres_and_colour_to_bgr() -> None:
    ob = library("pyorbbecsdk")
    driver, lensed = opened(Orbbec, "orbbec:?width=64&height=48")
    with closing(driver):
        matrix = lensed.color_from_depth.matrix
        assert np.allclose(matrix[:3, :3], ob.PLACE.rot)
        assert np.allclose(matrix[:3, 3], [0.032, 0.001, -0.002])
        assert np.allclose(lensed.color_distortion, (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8))
        ob.script.color = np.zeros((48, 64, 3), np.uint8)
        ob.script.color[..., 0] = 200
        ob.script.depth = np.full((24, 32), 1001, np.uint16)
        images = driver.read(0.1)
        assert images is not None
        assert images.depth is not None
        assert (images.color[0, 0] == (200, 0, 0)).all()
        assert (images.depth == 500).all()
        ob.script.half = True
        images = driver.read(0.1)
        assert images is not None
        assert images.color.shape != (48, 64, 3)


def test_an_oak_undoes_its_distortion_and_puts_depth_into_the_colour_view() -> None:
    dai = library("depthai")
    driver, lensed = opened(Oak, "oak:0815?width=64&height=48&fps=20")
    with closing(driver):
        assert lensed.color == lensed.depth
        assert not any(lensed.color_distortion)
        size, kind, given = dai.asked["color"]
        assert (size, kind) == ((64, 48), "bgr")
        assert given == {"fps": 20.0, "enableUndistortion": True}
        assert (dai.asked["align"], dai.asked["depth"]) == ("A", (64, 48))
        assert set(dai.asked["links"]) == {("A", "color"), ("depth", "depth")}
