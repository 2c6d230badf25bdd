"""Counting, blending and comparing colours, against their twins."""

import numpy as np
import pytest
import twins
from scenes import CAMERA, kernel_camera, random_image, random_lines, random_pose, unit_vectors

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.histogram import add_colors, blend, count_along, posterior_table
from snapfit.tracking.kernels.learn import learn_colors

CONSIDERED_PX = 15.0


def kernel_ray(
    color: np.ndarray, start: np.ndarray, direction: np.ndarray, from_px: float, length_px: float
) -> np.ndarray:
    counts = np.zeros(4096, dtype=np.float32)
    count_along(
        color,
        *start.astype(np.float32),
        *direction.astype(np.float32),
        np.float32(from_px),
        np.float32(length_px),
        counts,
    )
    return counts


def test_colours_along_a_ray_equal_their_twin() -> None:
    rng = np.random.default_rng(1)
    color = random_image(rng)
    n_compared, n_cut = 0, 0
    for direction in unit_vectors(rng, (500, 2)):
        start = rng.uniform(0, [CAMERA.width - 1, CAMERA.height - 1])
        from_px, length_px = rng.uniform(0, 5), rng.uniform(-3, 30)
        wanted, margin = twins.ray_bins(color, start + direction * from_px, direction, length_px)
        if margin < 1e-3:
            continue
        assert np.array_equal(kernel_ray(color, start, direction, from_px, length_px), wanted)
        n_compared += 1
        n_cut += wanted.sum() < np.floor(length_px * np.abs(direction).max() + 0.5)
    assert n_compared > 400
    assert n_cut > 20


@pytest.mark.parametrize(
    ("direction", "columns", "rows"),
    [
        ((1, 0), range(103, 123), [50] * 20),
        ((-1, 0), range(97, 77, -1), [50] * 20),
        ((0, 1), [100] * 20, range(53, 73)),
        ((0, -1), [100] * 20, range(47, 27, -1)),
    ],
)
def test_a_ray_along_an_axis_takes_each_pixel_once(
    direction: tuple[int, int], columns: list[int], rows: list[int]
) -> None:
    color = np.zeros((CAMERA.height, CAMERA.width, 3), dtype=np.uint8)
    color[list(rows), list(columns)] = 255
    counts = kernel_ray(color, np.array([100.0, 50.0]), np.array(direction), 3.0, 20.0)
    assert counts[4095] == 20
    assert counts.sum() == 20


@pytest.mark.parametrize("start", [(-9, 50), (250, 50), (50, -9), (50, 300)])
def test_a_ray_that_starts_outside_counts_nothing(start: tuple[int, int]) -> None:
    color = np.zeros((CAMERA.height, CAMERA.width, 3), dtype=np.uint8)
    for direction in (*np.eye(2), *-np.eye(2)):
        assert kernel_ray(color, np.array(start), direction, 1.0, 20.0).sum() == 0


def both_sides(
    color: np.ndarray, start: np.ndarray, place: np.ndarray, unconsidered_px: float
) -> tuple[np.ndarray, float]:
    """Colours (2, 4096) inside and outside of one line's contour; margin to rounding.

    From a margin, a quarter of the length where the body is thin, to the margin's mirror.
    """
    counts, margins = [], []
    for sign, continuous_px in ((-1, place[6]), (1, place[7])):
        begin_px = min(unconsidered_px, continuous_px / 4)
        length_px = min(CONSIDERED_PX, continuous_px - 2 * begin_px)
        normal = sign * place[2:4]
        bins, margin = twins.ray_bins(color, start + normal * begin_px, normal, length_px)
        counts.append(bins)
        margins.append(margin)
    return np.array(counts), min(margins)


@pytest.mark.parametrize("unconsidered_px", [0.5, 1.0, 8.0])
def test_colours_on_both_sides_of_the_contour(unconsidered_px: float) -> None:
    rng = np.random.default_rng(2)
    color, pose, n = random_image(rng), random_pose(rng), 400
    lines = random_lines(rng, n, pose)
    counts, wanted = np.zeros((2, 4096), dtype=np.float32), np.zeros((2, 4096))
    starts = CAMERA.project(pose.transform(lines.point[1].astype(np.float64)))
    for i, start in enumerate(starts):
        place = lines.place[1, i].astype(np.float64)
        colors, margin = both_sides(color, start, place, unconsidered_px)
        lines.valid[1, i] &= margin > 1e-3
        wanted += colors * lines.valid[1, i]
    assert lines.valid.sum() > 0.6 * n
    add_colors(
        1,
        n - 10,
        color,
        kernel_camera(),
        pose.matrix.astype(np.float32),
        lines,
        np.float32(unconsidered_px),
        np.float32(CONSIDERED_PX),
        counts,
    )
    for i in np.flatnonzero(lines.valid[1, n - 10 :]) + n - 10:
        place = lines.place[1, i].astype(np.float64)
        wanted -= both_sides(color, starts[i], place, unconsidered_px)[0]
    assert np.array_equal(counts, wanted)


def test_points_behind_the_camera_count_nothing() -> None:
    rng = np.random.default_rng(3)
    pose = random_pose(rng)
    lines, counts = random_lines(rng, 50, pose), np.zeros((2, 4096), dtype=np.float32)
    behind = Pose.from_translation(0, 0, -1.5) @ pose
    add_colors(
        1,
        50,
        random_image(rng),
        kernel_camera(),
        behind.matrix.astype(np.float32),
        lines,
        np.float32(1),
        np.float32(CONSIDERED_PX),
        counts,
    )
    assert not counts.any()


def random_counts(rng: np.random.Generator) -> np.ndarray:
    return (rng.poisson(0.3, 4096) * (rng.random(4096) < 0.2)).astype(np.float32)


@pytest.mark.parametrize("rate", [0.0, 0.2, 0.37, 1.0])
def test_blending_moves_a_histogram_by_its_rate(rate: float) -> None:
    rng = np.random.default_rng(4)
    histogram, counts = rng.dirichlet(np.ones(4096)).astype(np.float32), random_counts(rng)
    wanted = (1 - rate) * histogram.astype(np.float64) + rate * counts / counts.sum()
    blend(histogram, counts, np.float32(rate))
    assert np.allclose(histogram, wanted, rtol=1e-5, atol=1e-9)
    assert histogram.sum() == pytest.approx(1, abs=1e-4)
    assert not counts.any()


@pytest.mark.parametrize("rate", [0.2, 1.0])
def test_a_frame_without_colours_changes_nothing(rate: float) -> None:
    histogram = np.random.default_rng(5).dirichlet(np.ones(4096)).astype(np.float32)
    before = histogram.copy()
    blend(histogram, np.zeros(4096, dtype=np.float32), np.float32(rate))
    assert np.array_equal(histogram, before)


def test_the_posterior_table_equals_its_twin() -> None:
    rng = np.random.default_rng(6)
    foreground, background = (
        (random_counts(rng) / 1000).astype(np.float32),
        (random_counts(rng) / 500).astype(np.float32),
    )
    table = np.full(4096, np.nan, dtype=np.float32)
    posterior_table(foreground, background, table)
    seen = (foreground + background) > 0
    assert 100 < seen.sum() < 4000
    assert (table[~seen] == 0.5).all()
    wanted = foreground[seen] / (foreground[seen] + background[seen])
    assert np.allclose(table[seen], wanted, rtol=1e-6)
    assert {0.0, 1.0} <= set(table.tolist())


def learned(
    owner: list[int], learning: list[int], colors: np.ndarray, before: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Histograms and tables after learning at the rates 0.25 and 0.5."""
    histograms, tables = before.copy(), np.full((len(owner), 4096), 7, dtype=np.float32)
    learn_colors(
        np.array(owner),
        np.array(learning),
        colors.copy(),
        np.array([0.25, 0.5], dtype=np.float32),
        histograms,
        tables,
    )
    return histograms, tables


def blended(before: np.ndarray, counts: np.ndarray) -> np.ndarray:
    rates = np.array([0.25, 0.5])[:, None]
    return (1 - rates) * before + rates * counts / counts.sum(axis=1, keepdims=True)


@pytest.mark.parametrize("learning", [[1, 1, 1], [1, 0, 1], [0, 1, 0]])
def test_bodies_that_share_histograms_learn_together(learning: list[int]) -> None:
    rng = np.random.default_rng(7)
    colors = np.stack([[random_counts(rng) for _ in range(2)] for _ in range(3)])
    before = rng.dirichlet(np.ones(4096), (1, 2)).astype(np.float32)
    histograms, tables = learned([0, 0, 0], learning, colors, before)
    wanted = blended(before[0], (colors * np.array(learning)[:, None, None]).sum(axis=0))
    assert np.allclose(histograms[0], wanted, rtol=1e-4, atol=1e-9)
    # All of them see by what was learned, those that did not learn, too.
    assert np.array_equal(tables, np.repeat(tables[:1], 3, axis=0))
    assert np.allclose(tables[0], wanted[0] / wanted.sum(axis=0), rtol=1e-4)


def test_bodies_with_their_own_histograms_learn_by_themselves() -> None:
    rng = np.random.default_rng(8)
    colors = np.stack([[random_counts(rng) for _ in range(2)] for _ in range(3)])
    before = rng.dirichlet(np.ones(4096), (3, 2)).astype(np.float32)
    histograms, tables = learned([0, 1, 2], [1, 0, 1], colors, before)
    for body in (0, 2):
        wanted = blended(before[body], colors[body])
        assert np.allclose(histograms[body], wanted, rtol=1e-4, atol=1e-9)
        assert np.allclose(tables[body], wanted[0] / wanted.sum(axis=0), rtol=1e-4)
    assert np.array_equal(histograms[1], before[1])
    assert (tables[1] == 7).all()
