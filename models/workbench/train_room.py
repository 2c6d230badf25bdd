"""The room of a training image: bench, floor and wall with their surfaces, sheets, lamps."""

from __future__ import annotations

import math

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.backdrops import N_KINDS, PIXELS_PER_M, Kind
from snapfit.models.workbench.scene import Lamp
from snapfit.models.workbench.train_kernels import Sheets
from snapfit.models.workbench.train_stock import Stock

Rng = np.random.Generator

_HUGE_M = 30.0
_LIFT_M = 0.0005
# How often a bench shows each kind of surface.
_BENCH_SHARES = {
    Kind.WOOD: 5.0,
    Kind.CLOTH: 2.0,
    Kind.COATED: 3.0,
    Kind.MAT: 1.5,
    Kind.PAPER: 0.5,
    Kind.PLAIN: 3.0,
    Kind.CHECKS: 1.0,
    Kind.STONE: 2.0,
    Kind.STRIPES: 0.7,
    Kind.HEAP: 0.6,
}
_WALL_SHARES = {Kind.PLAIN: 3.0, Kind.HEAP: 4.0, Kind.STONE: 1.0, Kind.STRIPES: 0.5}
_SHEET_SHARES = {Kind.PAPER: 3.0, Kind.MAT: 2.0, Kind.CLOTH: 1.0, Kind.PLAIN: 2.0, Kind.HEAP: 1.0}


class _Builder:
    """Gathers sheets in the world frame, each with a surface of its own look."""

    def __init__(self, stock: Stock, camera: PinholeCamera, view: Pose, rng: Rng) -> None:
        self._stock, self._camera, self._view, self._rng = stock, camera, view, rng
        self._rows: dict[str, list[object]] = {name: [] for name in Sheets._fields}

    def add(
        self,
        world_from_sheet: Pose,
        halves_m: tuple[float, float],
        shares: dict[Kind, float],
        pixels_per_m: float,
    ) -> None:
        rng = self._rng
        kinds, weights = list(shares), np.array(list(shares.values()))
        kind = int(kinds[int(rng.choice(len(kinds), p=weights / weights.sum()))])
        variants = len(self._stock.surfaces) // N_KINDS
        surface = kind + N_KINDS * int(rng.integers(variants))
        pose = self._view @ world_from_sheet
        self._rows["frames"].append(pose.matrix[:3])
        self._rows["halves"].append(halves_m)
        self._rows["windows"].append(self._window(pose, halves_m))
        self._rows["surface"].append(surface)
        turn, shift = rng.uniform(0, 2 * math.pi), rng.uniform(0, 4096, 2)
        self._rows["texels"].append((pixels_per_m, turn, shift[0], shift[1]))
        self._rows["color"].append(_tinted(self._stock.means[surface], rng))
        self._rows["gloss"].append(max(rng.normal(0.0, 0.12), 0.0))

    def sheets(self) -> Sheets:
        rows = self._rows
        return Sheets(
            np.array(rows["frames"], dtype=np.float64),
            np.array(rows["halves"], dtype=np.float64),
            np.array(rows["windows"], dtype=np.int64),
            np.array(rows["surface"], dtype=np.int64),
            np.array(rows["texels"], dtype=np.float64),
            np.array(rows["color"], dtype=np.float32),
            np.array(rows["gloss"], dtype=np.float32),
        )

    def _window(self, pose: Pose, halves_m: tuple[float, float]) -> tuple[int, int, int, int]:
        camera = self._camera
        signs = np.array([(-1, -1, 0), (-1, 1, 0), (1, -1, 0), (1, 1, 0)])
        corners = pose.transform(signs * np.array([*halves_m, 0]))
        if corners[:, 2].min() < 0.02:
            return 0, camera.width, 0, camera.height
        pixels = camera.project(corners)
        size = np.array([camera.width, camera.height])
        low = np.clip(np.floor(pixels.min(axis=0)), 0, size).astype(int)
        high = np.clip(np.ceil(pixels.max(axis=0)) + 1, 0, size).astype(int)
        return int(low[0]), int(high[0]), int(low[1]), int(high[1])


def sampled_room(stock: Stock, camera: PinholeCamera, view: Pose, rng: Rng) -> Sheets:
    """Bench, floor, wall, and up to three sheets on the bench.

    Args:
        stock: with the surfaces.
        camera: that looks.
        view: `camera_from_world`.
        rng: of everything.
    """
    build = _Builder(stock, camera, view, rng)
    bench = (rng.uniform(0.4, 1.3), rng.uniform(0.35, 0.9))
    if rng.random() < 0.35:
        bench = (_HUGE_M, _HUGE_M)
    size = math.exp(rng.uniform(-0.8, 0.7))
    build.add(_flat(rng, 0.12, 0.0), bench, _BENCH_SHARES, PIXELS_PER_M * size)
    for i in range(int(rng.choice(4, p=(0.4, 0.3, 0.2, 0.1)))):
        halves = (rng.uniform(0.04, 0.22), rng.uniform(0.04, 0.16))
        fine = PIXELS_PER_M * math.exp(rng.uniform(0.0, 1.2))
        build.add(_flat(rng, 0.35, _LIFT_M * (i + 1)), halves, _SHEET_SHARES, fine)
    floor = _flat(rng, 0.0, -rng.uniform(0.4, 0.9))
    build.add(floor, (_HUGE_M, _HUGE_M), _BENCH_SHARES, rng.uniform(150, 700))
    # Upright, behind what the camera looks at.
    forward = view.rotation[2].copy()
    forward[2] = 0.0
    forward /= max(float(np.linalg.norm(forward)), 1e-6)
    if not forward.any():
        forward = np.array([0.0, 1.0, 0.0])
    side = np.array([forward[1], -forward[0], 0.0])
    rotation = np.column_stack([side, (0.0, 0.0, 1.0), -forward])
    wall = Pose.from_rotation_translation(rotation, forward * rng.uniform(0.9, 3.5))
    build.add(wall, (_HUGE_M, _HUGE_M), _WALL_SHARES, rng.uniform(60, 400))
    return build.sheets()


def sampled_lamps(rng: Rng) -> tuple[tuple[Lamp, ...], Array]:
    """One to three lamps, and (2, 3) light from above and from below; exposure comes later."""
    lamps = []
    for i in range(int(rng.choice((1, 2, 3), p=(0.35, 0.45, 0.2)))):
        height, around = math.radians(rng.uniform(28, 85)), rng.uniform(0, 2 * math.pi)
        distance = rng.uniform(0.9, 2.2)
        place = distance * np.array(
            [
                math.cos(height) * math.cos(around),
                math.cos(height) * math.sin(around),
                math.sin(height),
            ]
        )
        strength = rng.uniform(0.5, 1.2) if i == 0 else rng.uniform(0.1, 0.9)
        color = strength * distance**2 * _tone(rng, 0.18)
        diameter = math.exp(rng.uniform(math.log(0.02), math.log(0.6)))
        x, y, z = (float(value) for value in place)
        blue, green, red = (float(value) for value in color)
        lamps.append(Lamp((x, y, z), diameter, (blue, green, red)))
    above = rng.uniform(0.15, 0.8) * _tone(rng, 0.15)
    below = above * rng.uniform(0.15, 0.6) * _tone(rng, 0.1)
    return tuple(lamps), np.stack([above, below])


def _tone(rng: Rng, most: float) -> Array:
    """(3,) a tint from cool to warm, blue first."""
    warm, green = rng.normal(0, most / 1.5), rng.normal(0, most / 5)
    tint: Array = np.clip(np.array([1 - warm, 1 + green, 1 + warm]), 0.4, 1.6)
    return tint


def _flat(rng: Rng, spread_m: float, z_m: float) -> Pose:
    """`world_from_sheet` of one that lies level."""
    yaw = Pose.exp([0, 0, rng.uniform(0, 2 * math.pi), 0, 0, 0]).rotation
    x_m, y_m = rng.normal(0, 1, 2) * spread_m
    return Pose.from_rotation_translation(yaw, (x_m, y_m, z_m))


def _tinted(mean: Array, rng: Rng) -> Array:
    """(3, 4) affine map of linear colours that gives a surface another colour and brightness."""
    luminance = np.array([0.072, 0.715, 0.213])
    saturation = rng.uniform(0.1, 0.8)
    gray = np.outer(np.ones(3), luminance)
    matrix = saturation * np.eye(3) + (1 - saturation) * gray
    if rng.random() < 0.3:
        matrix = matrix[rng.permutation(3)]
    brightness = math.exp(rng.uniform(math.log(0.05), math.log(0.65)))
    gain = np.clip(brightness / max(float(mean @ luminance), 0.01), 0.25, 4.0)
    matrix = matrix * gain * _tone(rng, 0.12)[:, None]
    return np.column_stack([matrix, np.full(3, rng.uniform(0, 0.015))])
