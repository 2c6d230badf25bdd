"""Measured and modelled occlusion against their twins."""

import numpy as np
import pytest
from scenes import CAMERA, focal_and_center, kernel_camera, occlusion

from snapfit.tracking.kernels.occlusion import hidden_measured, hidden_modelled

UNIT_M = 0.001
RADIUS_M, THRESHOLD_M, MODELLED_THRESHOLD_M = 0.01, 0.02, 0.005


def measured_twin(depth: np.ndarray, point: np.ndarray, offset_m: float) -> tuple[bool, float]:
    """Whether any sample around a point is nearer than point, own relief and threshold; margin."""
    uv = CAMERA.project(point)
    radius_px = RADIUS_M * CAMERA.fx / point[2]
    stride = max(1, int(radius_px / 2 + 1))
    low = np.maximum(np.floor(uv - radius_px + 0.5), 0).astype(int)
    high = np.minimum(np.floor(uv + radius_px + 0.5), [CAMERA.width - 1, CAMERA.height - 1])
    rows, columns = (np.arange(low[i], int(high[i]) + 1, stride) for i in (1, 0))
    values = depth[np.ix_(rows, columns)].astype(np.int64)
    there = values[(values > 0) & (values < 65535)] * UNIT_M
    limit = np.floor((point[2] - offset_m - THRESHOLD_M) / UNIT_M) * UNIT_M
    margins = [uv - radius_px, uv + radius_px]
    distances = [abs(m + 0.5 - round(m + 0.5)) for pair in margins for m in pair]
    near = abs(limit / UNIT_M - (point[2] - offset_m - THRESHOLD_M) / UNIT_M)
    return bool((there < limit - 1e-9).any()), min(*distances, near, 1 - near)


def kernel_measured(
    depth: np.ndarray, point: np.ndarray, offset_m: float = 0.0, unit_m: float = UNIT_M
) -> bool:
    hidden: bool = hidden_measured(
        depth,
        kernel_camera(),
        np.float32(unit_m),
        *point.astype(np.float32),
        np.float32(offset_m + THRESHOLD_M),
        occlusion(measured=True),
    )
    return hidden


def test_measured_occlusion_equals_its_twin() -> None:
    rng = np.random.default_rng(1)
    n_hidden, n_seen = 0, 0
    for trial in range(600):
        depth = np.full((CAMERA.height, CAMERA.width), 600, dtype=np.uint16)
        near = rng.random(depth.shape) < 0.02
        depth[near] = rng.integers(520, 600, int(near.sum()))
        depth[rng.random(depth.shape) < 0.3] = rng.choice([0, 65535])
        uv = rng.uniform(0, [CAMERA.width - 1, CAMERA.height - 1])
        if trial % 4 == 0:
            uv[trial % 8 // 4] = 0.3
        z = rng.uniform(0.15, 0.7)
        point = np.array([*(uv - focal_and_center()[2:]) / focal_and_center()[:2] * z, z])
        offset_m = rng.choice([0.0, rng.uniform(0, 0.05)])
        wanted, margin = measured_twin(depth, point, offset_m)
        if margin < 2e-3:
            continue
        assert kernel_measured(depth, point, offset_m) == wanted
        n_hidden += wanted
        n_seen += not wanted
    assert n_hidden > 50
    assert n_seen > 50


@pytest.mark.parametrize(("count", "hides"), [(0, False), (65535, False), (450, True), (478, True)])
def test_holes_hide_nothing_and_something_near_does(count: int, hides: bool) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), count, dtype=np.uint16)
    assert kernel_measured(depth, np.array([0.0, 0.0, 0.5])) == hides


@pytest.mark.parametrize(("count", "hides"), [(0, False), (65535, False), (65534, True)])
def test_holes_hide_nothing_where_the_unit_is_fine_too(count: int, hides: bool) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), count, dtype=np.uint16)
    assert kernel_measured(depth, np.array([0.0, 0.0, 0.5]), unit_m=0.3 / 65535) == hides


@pytest.mark.parametrize("count", [481, 500, 900])
def test_what_is_not_nearer_by_the_threshold_hides_nothing(count: int) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), count, dtype=np.uint16)
    assert not kernel_measured(depth, np.array([0.0, 0.0, 0.5]))


def test_the_bodys_own_relief_hides_nothing() -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 470, dtype=np.uint16)
    point = np.array([0.0, 0.0, 0.5])
    assert kernel_measured(depth, point, 0.005)
    assert not kernel_measured(depth, point, 0.015)


@pytest.mark.parametrize("point", [(0, 0, -0.5), (0, 0, 0), (9, 0, 0.5), (-9, 0, 0.5), (0, 9, 0.5)])
def test_where_the_depth_camera_does_not_look_nothing_hides(point: tuple[float, ...]) -> None:
    depth = np.full((CAMERA.height, CAMERA.width), 100, dtype=np.uint16)
    assert not kernel_measured(depth, np.array(point, dtype=np.float64))


def kernel_modelled(
    near_depth: np.ndarray, near_id: np.ndarray, uv: np.ndarray, z: float, radius_px: float
) -> bool:
    hidden: bool = hidden_modelled(
        near_depth,
        near_id,
        2,
        np.float32(uv[0]),
        np.float32(uv[1]),
        np.float32(z),
        np.float32(radius_px),
        occlusion(modelled=True),
    )
    return hidden


def test_modelled_occlusion_equals_its_twin() -> None:
    """A picture of half the size: pixel (c, r) has its centre at (2 c + 0.5, 2 r + 0.5)."""
    rng = np.random.default_rng(2)
    n_hidden, n_seen = 0, 0
    for trial in range(600):
        near_id = rng.choice(4, (40, 60), p=[0.94, 0.02, 0.02, 0.02]).astype(np.uint8)
        near_depth = (rng.uniform(0.4, 0.6, near_id.shape) * (near_id > 0)).astype(np.float32)
        uv, z = rng.uniform(0, [118, 78]), rng.uniform(0.45, 0.6)
        if trial % 4 == 0:
            uv[trial % 8 // 4] = 0.2
        radius_px = rng.choice([0.3, rng.uniform(0, 12)])
        center, reach = (uv + 0.5) / 2 - 0.5, max(radius_px / 2, 0.5)
        low, high = np.floor(center - reach + 0.5), np.floor(center + reach + 0.5)
        if np.abs([center - reach, center + reach] - np.array([low, high]) + 0.5).min() < 1e-4:
            continue
        rows, columns = np.mgrid[:40, :60]
        window = (rows >= low[1]) & (rows <= high[1]) & (columns >= low[0]) & (columns <= high[0])
        other = (near_id != 0) & (near_id != 2)
        wanted = bool((window & other & (near_depth < z - MODELLED_THRESHOLD_M)).any())
        assert kernel_modelled(near_depth, near_id, uv, z, radius_px) == wanted
        n_hidden += wanted
        n_seen += not wanted
    assert n_hidden > 50
    assert n_seen > 50


@pytest.mark.parametrize(
    ("body_id", "depth_m", "hides"),
    [(1, 0.4, True), (3, 0.4, True), (2, 0.4, False), (0, 0.0, False), (1, 0.497, False)],
)
def test_another_body_hides_and_nothing_and_itself_do_not(
    body_id: int, depth_m: float, hides: bool
) -> None:
    near_id = np.full((40, 60), body_id, dtype=np.uint8)
    near_depth = np.full((40, 60), depth_m, dtype=np.float32)
    for uv in ((0, 0), (60, 40), (119, 79)):
        assert kernel_modelled(near_depth, near_id, np.array(uv), 0.5, 3.0) == hides
