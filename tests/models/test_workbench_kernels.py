"""The workbench's kernels against plain NumPy, and shadows against what is known of them."""

import math

import numpy as np
import pytest

from snapfit.models.workbench import kernels, sensor_kernels

UP = np.array([0.0, -0.6, -0.8])


def lamps(shadow=None, diameter_m=0.1, intensity=(1.0, 0.9, 0.8)):
    """One lamp 1 m before the camera's plane, at the camera's place, that looks along z."""
    size = 400
    shadow = np.zeros((size, size), np.float32) if shadow is None else shadow
    taps = [
        (math.sqrt((i + 0.5) / n) * math.cos(2.4 * i), math.sqrt((i + 0.5) / n) * math.sin(2.4 * i))
        for n in (kernels.SEARCH_TAPS, kernels.FILTER_TAPS)
        for i in range(n)
    ]
    return kernels.Lamps(
        rows=np.array([[0.0, 0, 0, diameter_m, *intensity]]),
        ambient=np.array([[0.3, 0.2, 0.1], [0.05, 0.05, 0.05]]),
        up=UP,
        map_lamp=np.array([0]),
        lamp_from_camera=np.eye(4)[None],
        lenses=np.array([[size, size, (size - 1) / 2, (size - 1) / 2]], dtype=np.float64),
        shadows=shadow[None],
        casts=np.full((1, size, size), 255, np.uint8),
        taps=np.array(taps),
    )


def plane(rng, height=40, width=60):
    depth = rng.uniform(0.9, 1.1, (height, width)).astype(np.float32)
    normal = rng.normal((0, 0, -2), 0.5, (height, width, 3)).astype(np.float32)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    albedo = rng.random((height, width, 3), dtype=np.float32)
    gloss = rng.choice(np.array([0, 0.3], np.float32), (height, width))
    return depth, normal, albedo, gloss


INTRINSICS = np.array([100.0, 110.0, 29.0, 19.0])


def shade_numpy(depth, normal, albedo, gloss, light):
    rows, columns = np.indices(depth.shape)
    x = (columns - INTRINSICS[2]) / INTRINSICS[0] * depth
    y = (rows - INTRINSICS[3]) / INTRINSICS[1] * depth
    point = np.stack([x, y, depth.astype(np.float64)], -1)
    upward = (0.5 + 0.5 * normal @ UP)[..., None]
    out = albedo * (light.ambient[0] * upward + light.ambient[1] * (1 - upward))
    to_lamp = light.rows[0, :3] - point
    distance = np.linalg.norm(to_lamp, axis=-1)
    to_lamp = to_lamp / distance[..., None]
    cosine = np.maximum((normal * to_lamp).sum(-1), 0)
    half = to_lamp - point / np.linalg.norm(point, axis=-1, keepdims=True)
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    glint = gloss * np.maximum((normal * half).sum(-1), 0) ** 24
    strength = (cosine / distance**2)[..., None] * light.rows[0, 4:]
    return out + strength * (albedo + glint[..., None])


def test_shading_without_shadows_is_lambert_and_blinn_phong():
    surfaces = plane(np.random.default_rng(1))
    light = lamps()
    shaded = kernels.shade(*surfaces, INTRINSICS, np.array([0, 0]), light)
    np.testing.assert_allclose(shaded, shade_numpy(*surfaces, light), atol=2e-5)


def test_where_nothing_is_it_stays_black():
    depth, normal, albedo, gloss = plane(np.random.default_rng(1))
    depth[5:9] = 0
    shaded = kernels.shade(depth, normal, albedo, gloss, INTRINSICS, np.array([0, 0]), lamps())
    assert (shaded[5:9] == 0).all()
    assert (shaded[9:] > 0).all()


def wall(height=40, width=60):
    depth = np.ones((height, width), np.float32)
    normal = np.zeros((height, width, 3), np.float32)
    normal[..., 2] = -1
    return depth, normal, np.ones((height, width, 3), np.float32), np.zeros_like(depth)


def test_behind_a_screen_only_the_ambient_light_is_left():
    screen = np.full((400, 400), 0.9, np.float32)
    light = lamps(screen)
    shaded = kernels.shade(*wall(), INTRINSICS, np.array([0, 0]), light)
    lit = kernels.shade(*wall(), INTRINSICS, np.array([0, 0]), lamps())
    upward = 0.5 + 0.5 * 0.8
    expected = light.ambient[0] * upward + light.ambient[1] * (1 - upward)
    np.testing.assert_allclose(shaded, np.broadcast_to(expected, shaded.shape), rtol=1e-5)
    assert (lit > shaded + 0.3).all()


def test_a_larger_lamp_and_a_farther_blocker_make_a_softer_edge():
    close_up = np.array([1000.0, 1000, 29.5, 19.5])

    def width_of_edge(diameter_m, blocker_m):
        half = np.zeros((400, 400), np.float32)
        half[:, :200] = blocker_m
        full, lit, shaded = (
            kernels.shade(*wall(), close_up, np.array([0, 0]), lamps(shadow, diameter_m))
            for shadow in (np.full((400, 400), 0.9, np.float32), None, half)
        )
        share = ((shaded - full) / (lit - full))[..., 0].mean(axis=0)
        return int(((share > 0.05) & (share < 0.95)).sum()), share

    narrow, share = width_of_edge(0.05, 0.95)
    assert share[:10].max() < 0.05
    assert share[-10:].min() > 0.95
    assert narrow < width_of_edge(0.3, 0.95)[0]
    assert narrow < width_of_edge(0.05, 0.7)[0] + 1


def test_pixels_are_the_weighted_mean_of_their_samples():
    rng = np.random.default_rng(2)
    samples = rng.random((2 * 6 + 4, 2 * 9 + 4, 3), dtype=np.float32) ** 2
    encoding = np.linspace(0, 255, 1024).round().astype(np.uint8)
    weights = np.outer([1, 3, 3, 1], [1, 3, 3, 1]) / 64
    expected = np.empty((6, 9, 3))
    for row, column in np.ndindex(6, 9):
        window = samples[2 * row + 1 : 2 * row + 5, 2 * column + 1 : 2 * column + 5]
        expected[row, column] = (window * weights[..., None]).sum(axis=(0, 1))
    pixels = kernels.to_pixels(samples, encoding)
    np.testing.assert_allclose(pixels, np.sqrt(expected) * 255, atol=1)


def test_color_noise_is_scaled_by_brightness_and_clipped():
    rng = np.random.default_rng(3)
    clean = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    noise = rng.integers(-100, 100, clean.shape, dtype=np.int8)
    gain = np.linspace(0, 0.5, 256).astype(np.float32)
    expected = np.clip(np.floor(clean + noise * gain[clean] + 0.5), 0, 255)
    np.testing.assert_array_equal(sensor_kernels.noisy_color(clean, noise, gain), expected)


def depth_case(depth):
    zeros = np.zeros_like(depth)
    return {
        "depth": depth,
        "nearest": depth.copy(),
        "farthest": depth.copy(),
        "bias": zeros,
        "noise": zeros.copy(),
        "chance": zeros.copy(),
        "seen": np.ones(depth.shape, bool),
        "step_m": 0.01,
        "hole_share": 0.3,
        "flying_share": 0.4,
    }


def measured(case):
    return sensor_kernels.noisy_depth(*case.values())


def test_depth_is_millimetres_with_noise_and_bias():
    rng = np.random.default_rng(4)
    case = depth_case(rng.uniform(0.3, 3, (30, 40)).astype(np.float32))
    case["noise"] = rng.standard_normal((30, 40), dtype=np.float32)
    case["bias"] = rng.normal(0, 0.001, (30, 40)).astype(np.float32)
    sigma = 0.0004 + 0.0014 * case["depth"] ** 2
    expected = (case["depth"] + case["bias"] + sigma * case["noise"]) * 1000
    np.testing.assert_allclose(measured(case), expected, atol=0.51)


def test_edges_have_holes_and_flying_pixels():
    case = depth_case(np.full((1, 4), 0.6, np.float32))
    case["farthest"][:] = 0.8
    case["chance"][:] = [0.1, 0.3 + 0.1, 0.3 + 0.3, 0.9]
    np.testing.assert_array_equal(measured(case), [[0, 650, 750, 600]])


@pytest.mark.parametrize("key", ["depth", "seen"])
def test_there_is_no_depth_where_nothing_is_or_nothing_looks(key):
    case = depth_case(np.full((2, 3), 0.6, np.float32))
    case[key][0, 1] = 0
    assert measured(case)[0, 1] == 0
    assert (np.delete(measured(case).ravel(), 1) == 600).all()
