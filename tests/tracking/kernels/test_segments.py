"""Segment probabilities, posterior and moments of a correspondence line, against their twins."""

import math

import numpy as np
import pytest
import twins
from scenes import CAMERA, random_image, unit_vectors

from snapfit.tracking.kernels.region import moments, posterior, segment_probabilities
from snapfit.tracking.parameters import RegionParameters
from snapfit.tracking.region_modality import region_settings

SCALES = range(1, 10)
PAPER = RegionParameters(amplitude=0.43, slope=0.5)


# Kernels work on rows of the arrays of all lines; here on this one.
ROW, N_ROWS = 2, 4


def kernel_segments(
    color: np.ndarray, table: np.ndarray, scale: int, center: np.ndarray, normal: np.ndarray
) -> tuple[bool, np.ndarray, np.ndarray]:
    """Whether the line is in the image; its place (8,); its foreground (19,)."""
    places = np.zeros((N_ROWS, 8), dtype=np.float32)
    places[ROW, :2], places[ROW, 2:4] = center, normal
    foreground = np.full(19, np.nan, dtype=np.float32)
    inside = segment_probabilities(color, table, scale, places, ROW, foreground)
    assert not np.delete(places, ROW, axis=0).any()
    return inside, places[ROW], foreground


def kernel_posterior(foreground: np.ndarray, step: np.ndarray) -> np.ndarray:
    """(12,) posterior of the foreground (19,)."""
    out = np.zeros((N_ROWS, 12), dtype=np.float32)
    posterior(foreground.astype(np.float32), step, out, ROW)
    assert not np.delete(out, ROW, axis=0).any()
    return out[ROW]


def kernel_moments(distribution: np.ndarray) -> tuple[float, float]:
    """Mean and variance of a posterior (12,); the smallest variance is 0.5."""
    distributions, out = np.zeros((N_ROWS, 12)), np.zeros((N_ROWS, 2), dtype=np.float32)
    distributions[ROW] = distribution
    moments(distributions.astype(np.float32), ROW, np.float32(0.5), out)
    assert not np.delete(out, ROW, axis=0).any()
    return float(out[ROW, 0]), float(out[ROW, 1])


def random_table(rng: np.random.Generator) -> np.ndarray:
    """Posteriors by colour; some are sure of the foreground, some of the background."""
    table = rng.uniform(0.001, 0.999, 4096).astype(np.float32)
    table[rng.random(4096) < 0.05] = 0
    table[rng.random(4096) < 0.05] = 1
    return table


def random_normals(rng: np.random.Generator, n: int) -> np.ndarray:
    """All directions, and those along the axes and the diagonals among them."""
    special = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]])
    normals = np.concatenate([unit_vectors(rng, (n - 8, 2)), special])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals.astype(np.float32).astype(np.float64)


@pytest.mark.parametrize("scale", SCALES)
def test_segments_equal_their_twin(scale: int) -> None:
    rng = np.random.default_rng(scale)
    color, table = random_image(rng), random_table(rng)
    centers = rng.uniform(-5, [CAMERA.width + 5, CAMERA.height + 5], (300, 2)).astype(np.float32)
    n_inside, n_sure = 0, 0
    for center, normal in zip(centers.astype(np.float64), random_normals(rng, 300), strict=True):
        pixels = twins.line_pixels(center, normal, 19 * scale)
        inside, place, foreground = kernel_segments(color, table, scale, center, normal)
        assert inside == twins.is_inside(pixels, CAMERA.width, CAMERA.height)
        if not inside:
            continue
        wanted = twins.segment_probabilities(color, table, pixels, normal, scale)
        sure = wanted.is_sure
        assert np.allclose(foreground[sure], wanted.foreground[sure], rtol=2e-4, atol=2e-6)
        assert place[4] == pytest.approx(wanted.offset_px, abs=2e-4)
        assert place[5] == pytest.approx(wanted.segments_per_px, rel=1e-5)
        assert place[:4] == pytest.approx([*center, *normal])
        n_inside += 1
        n_sure += int(sure.sum())
    assert n_inside > 15
    assert n_sure > 0.8 * 19 * n_inside


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("scale", SCALES)
def test_a_line_may_reach_the_last_pixel_but_not_go_beyond(
    scale: int, axis: int, sign: int
) -> None:
    color = np.zeros((CAMERA.height, CAMERA.width, 3), dtype=np.uint8)
    table = np.full(4096, 0.3, dtype=np.float32)
    normal = np.zeros(2)
    normal[axis] = sign
    size = (CAMERA.width, CAMERA.height)[axis]
    half = (19 * scale - 1) / 2
    for place, wanted in ((half, True), (half - 1, False)):
        for center_along in (place, size - 1 - place):
            center = np.full(2, 100.0)
            center[axis] = center_along
            inside, line, segments = kernel_segments(color, table, scale, center, normal)
            assert inside == wanted
            if inside:
                assert line[4] == 0
                assert np.isfinite(segments).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_slanting_line_may_not_leave_the_image_sideways(axis: int) -> None:
    rng = np.random.default_rng(axis)
    color, table = random_image(rng), random_table(rng)
    normal = np.array([0.8, 0.6])[:: 1 if axis == 0 else -1]
    last = (CAMERA.height, CAMERA.width)[axis] - 1
    sideways = 9 * 0.6 / 0.8
    for beside, wanted in ((0.05, True), (-0.05, False)):
        for place in (sideways + beside, last - sideways - beside):
            center = np.full(2, 100.0)
            center[1 - axis] = place
            inside, _, segments = kernel_segments(color, table, 1, center, normal)
            assert inside == wanted
            assert np.isfinite(segments).all() == wanted


@pytest.mark.parametrize("scale", [2, 5, 9])
def test_segments_that_contradict_themselves_say_nothing(scale: int) -> None:
    """A pixel that cannot be foreground beside one that cannot be background."""
    color = np.zeros((CAMERA.height, CAMERA.width, 3), dtype=np.uint8)
    color[:, ::2] = 255
    table = np.full(4096, 0.5, dtype=np.float32)
    table[0], table[4095] = 0, 1
    inside, _, segments = kernel_segments(
        color, table, scale, np.array([120.2, 99.7]), np.array([1.0, 0.0])
    )
    assert inside
    assert (segments == 0.5).all()


@pytest.mark.parametrize(("amplitude", "slope"), [(0.43, 0.5), (0.36, 1.0), (0.49, 0.3)])
def test_the_posterior_equals_its_twin(amplitude: float, slope: float) -> None:
    rng = np.random.default_rng(3)
    parameters = RegionParameters(amplitude=amplitude, slope=slope)
    step = region_settings(parameters, 1).step_foreground
    x = np.arange(8) - 3.5
    assert np.allclose(step, 0.5 - amplitude * np.tanh(x / (2 * slope)), atol=1e-6)
    for _ in range(200):
        foreground = rng.beta(0.3, 0.3, 19).astype(np.float32)
        foreground[rng.random(19) < 0.1] = rng.integers(0, 2)
        out = kernel_posterior(foreground, step)
        assert out.sum() == pytest.approx(1, abs=1e-5)
        assert np.allclose(out, twins.posterior(foreground, step), rtol=1e-4, atol=1e-7)


@pytest.mark.parametrize("n_inside", range(6, 14))
def test_the_posterior_of_a_clear_edge_has_its_summit_there(n_inside: int) -> None:
    """Foreground up to an edge: the mean of the posterior is the edge's offset."""
    foreground = np.where(np.arange(19) < n_inside, 0.999, 0.001).astype(np.float32)
    out = kernel_posterior(foreground, region_settings(PAPER, 1).step_foreground)
    assert int(np.argmax(out)) == n_inside - 4
    mean, variance = kernel_moments(out)
    assert mean == pytest.approx(n_inside - 9.5, abs=0.05)
    assert 0.5 < variance < 0.8


def test_moments_equal_their_twin() -> None:
    rng = np.random.default_rng(5)
    raised = 0
    for concentration in np.geomspace(0.02, 100, 300):
        distribution = rng.dirichlet(np.full(12, concentration)).astype(np.float32)
        out = kernel_moments(distribution)
        mean, variance = twins.moments(distribution, 0.5)
        assert out[0] == pytest.approx(mean, abs=1e-5)
        assert out[1] == pytest.approx(variance, rel=1e-4)
        raised += variance == 0.5
    assert 10 < raised < 200


def test_an_even_distribution_has_the_variance_of_its_bins() -> None:
    mean, variance = kernel_moments(np.full(12, 1 / 12))
    assert mean == pytest.approx(0, abs=1e-6)
    assert variance == pytest.approx((12**2 - 1) / 12, rel=1e-5)


def test_the_smallest_variance_is_that_of_the_paper() -> None:
    """SRT3D, equation 29: 1 / (2 atanh(2 amplitude)^2), and no less than the slope."""
    assert PAPER.min_variance == 0.5
    wide = RegionParameters(amplitude=0.3, slope=0.1)
    assert wide.min_variance == pytest.approx(1 / (2 * math.atanh(0.6) ** 2))
