"""The trackers' numeric parameters, and how the kernels take them."""

import dataclasses

import numpy as np
import pytest

from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.nearby import occlusion_settings
from snapfit.tracking.parameters import (
    DISTRIBUTION_LENGTH,
    FUNCTION_LENGTH,
    LINE_SEGMENTS,
    DepthParameters,
    HistogramParameters,
    OcclusionParameters,
    OptimiserParameters,
    RegionParameters,
    StartParameters,
    TrackerParameters,
    per_iteration,
)
from snapfit.tracking.region_modality import empty_lines, region_settings


@pytest.mark.parametrize(
    ("values", "iterations", "wanted"),
    [
        ((9, 7, 5, 2), 6, [9, 7, 5, 2, 2, 2]),
        ((9, 7, 5, 2), 4, [9, 7, 5, 2]),
        ((9, 7, 5, 2), 2, [9, 7]),
        ((0.5,), 3, [0.5, 0.5, 0.5]),
        ((1, 2), 0, []),
    ],
)
def test_the_last_value_repeats(
    values: tuple[float, ...], iterations: int, wanted: list[float]
) -> None:
    result = per_iteration(values, iterations)
    assert result == wanted
    assert all(isinstance(value, float) for value in result)


def test_a_line_has_a_segment_for_each_bin_and_tap() -> None:
    assert (DISTRIBUTION_LENGTH, FUNCTION_LENGTH, LINE_SEGMENTS) == (12, 8, 19)


def test_a_tracker_needs_a_modality() -> None:
    with pytest.raises(TrackingError, match="region modality, the depth modality, or both"):
        TrackerParameters(region=None, depth=None)
    assert TrackerParameters(depth=None).region is not None
    assert TrackerParameters(region=None).depth is not None


@pytest.mark.parametrize(
    "parameters",
    [
        TrackerParameters(),
        RegionParameters(),
        DepthParameters(),
        HistogramParameters(),
        OcclusionParameters(),
        OptimiserParameters(),
        StartParameters(),
    ],
    ids=lambda parameters: type(parameters).__name__,
)
def test_parameters_are_frozen_and_their_fields_documented(parameters: object) -> None:
    name = dataclasses.fields(parameters)[0].name  # type: ignore[arg-type]
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(parameters, name, None)
    documented = type(parameters).__doc__ or ""
    if not isinstance(parameters, TrackerParameters):
        for field in dataclasses.fields(parameters):  # type: ignore[arg-type]
            assert field.name in documented


def test_region_settings_have_an_entry_for_each_iteration() -> None:
    settings = region_settings(
        RegionParameters(scales_px=(6, 2), standard_deviations_px=(15.0, 5.0, 1.5)), 4
    )
    assert settings.scales.tolist() == [6, 2, 2, 2]
    assert settings.sigmas.tolist() == [15.0, 5.0, 1.5, 1.5]
    assert settings.scales.dtype == np.int64
    assert settings.sigmas.dtype == settings.step_foreground.dtype == np.float32
    assert settings.step_foreground.shape == (FUNCTION_LENGTH,)


def test_the_step_function_falls_and_is_odd_about_one_half() -> None:
    for amplitude in (0.2, 0.43, 0.49):
        step = region_settings(RegionParameters(amplitude=amplitude), 1).step_foreground
        assert (np.diff(step) <= 0).all()
        assert np.allclose(step + step[::-1], 1)
        assert step.max() <= 0.5 + amplitude


def test_depth_settings_have_an_entry_for_each_iteration() -> None:
    parameters = DepthParameters(
        considered_distances_m=(0.1, 0.05), standard_deviations_m=(0.03,), strides_m=(0.01, 0.004)
    )
    settings = depth_settings(parameters, 3)
    assert settings.considered.tolist() == pytest.approx([0.1, 0.05, 0.05])
    assert settings.sigmas.tolist() == pytest.approx([0.03] * 3)
    assert settings.strides.tolist() == pytest.approx([0.01, 0.004, 0.004])


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("has_depth", [True, False])
def test_without_a_depth_camera_nothing_is_measured(measured: bool, has_depth: bool) -> None:
    settings = occlusion_settings(OcclusionParameters(measured=measured), has_depth=has_depth)
    assert settings.measured == (measured and has_depth)
    assert settings.modelled


@pytest.mark.parametrize(("n", "wanted"), [(0, 1), (1, 1), (300, 300)])
def test_working_arrays_are_empty_and_never_of_no_size(n: int, wanted: int) -> None:
    """Kernels take rows of them even where a modality is left out."""
    lines, points = empty_lines(3, n), empty_points(3, n)
    for array in (*lines, *points):
        assert array.shape[:2] == (3, wanted)
        assert not array.any()
    assert lines.posterior.shape[2] == DISTRIBUTION_LENGTH


@pytest.mark.parametrize("amplitude", [0.0, 0.5, -0.1, float("nan")])
def test_an_amplitude_that_is_no_step_is_refused(amplitude: float) -> None:
    with pytest.raises(TrackingError, match="amplitude"):
        RegionParameters(amplitude=amplitude)


@pytest.mark.parametrize("scales_px", [(), (2, 0)])
def test_scales_under_a_pixel_are_refused(scales_px: tuple[int, ...]) -> None:
    with pytest.raises(TrackingError, match="scales_px"):
        RegionParameters(scales_px=scales_px)


def test_a_parameter_without_value_is_refused() -> None:
    with pytest.raises(TrackingError, match="at least one"):
        per_iteration((), 3)
