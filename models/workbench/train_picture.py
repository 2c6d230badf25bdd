"""Draws a training scene quickly: a sample a pixel, shadows, and what a camera does to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.rasteriser import intrinsics_of, render
from snapfit.models.workbench import (
    cover_kernels,
    kernels,
    sensor_kernels,
    stage_kernels,
    train_kernels,
)
from snapfit.models.workbench.hand import Body
from snapfit.models.workbench.scene import Scene, linear
from snapfit.models.workbench.shading import LampCamera, Surfaces, encoding, kernel_lamps
from snapfit.models.workbench.stage import HAND_LABEL, ITEM_LABEL, smooth_normals
from snapfit.models.workbench.train_scene import TrainScene
from snapfit.models.workbench.train_stock import Stock

Rng = np.random.Generator
Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

_LIGHT_OF_BYTE = linear(np.arange(256, dtype=np.uint8))
_ENCODING = encoding()
# Half the width of what a lamp's shadow map covers.
_SHADOW_M = 0.5
_READ_NOISE, _SHOT_NOISE, _NOISE_STEPS = 1.1, 1.5, 24.0


@dataclass(frozen=True, eq=False)
class TrainPicture:
    """A picture and what is seen in it.

    Attributes:
        color: (H, W, 3) uint8, blue first, as the camera delivers it.
        depth: (H, W) true depth, m, 0 is nothing.
        label: (H, W) i + 1 is the scene's i-th part; from 100 on other things, 200 the hand.
    """

    color: Bytes
    depth: Singles
    label: Bytes


@dataclass(frozen=True, eq=False)
class Optics:
    """What the camera does.

    Attributes:
        brightness: mean linear light that it is set to.
        balance: (3,) error of the white balance, blue first.
        falloff: how much darker the corners are.
        shoulder: light from which on highlights are pressed together.
        focus_px: blur of what is out of focus, standard deviation.
        smear_px: (2,) way of the picture during the exposure; zero if nothing moves.
        is_shake: the whole picture moves; else the parts alone.
        noise: times that of a good camera in good light.
    """

    brightness: float
    balance: Singles
    falloff: float
    shoulder: float
    focus_px: float
    smear_px: tuple[float, float]
    is_shake: bool
    noise: float

    @staticmethod
    def sampled(rng: Rng, scale: float = 1.0) -> Optics:
        """Mostly a good camera at rest."""
        smear, angle = 0.0, rng.uniform(0, math.pi)
        if rng.random() < 0.3:
            smear = scale * math.exp(rng.uniform(math.log(1.5), math.log(14)))
        return Optics(
            brightness=math.exp(rng.uniform(math.log(0.07), math.log(0.33))),
            balance=(1 + rng.normal(0, 0.04, 3)).astype(np.float32),
            falloff=rng.uniform(0, 0.4) if rng.random() < 0.5 else 0.0,
            shoulder=rng.uniform(0.6, 0.95),
            focus_px=scale * (rng.uniform(0.4, 1.5) if rng.random() < 0.35 else 0.0),
            smear_px=(smear * math.cos(angle), smear * math.sin(angle)),
            is_shake=bool(rng.random() < 0.3),
            noise=math.exp(rng.uniform(math.log(0.4), math.log(4.0))),
        )


def drawn(scene: TrainScene, stock: Stock, optics: Optics, rng: Rng) -> TrainPicture:
    """The scene as the camera sees it."""
    camera = scene.camera
    shape, lens = (camera.height, camera.width), intrinsics_of(camera)
    depth, which = np.empty(shape, np.float32), np.empty(shape, np.uint8)
    surfaces = Surfaces(
        depth,
        np.empty((*shape, 3), np.float32),
        np.empty((*shape, 3), np.float32),
        np.empty(shape, np.float32),
    )
    train_kernels.hit_sheets(scene.sheets, lens, depth, which)
    train_kernels.paint_sheets(
        scene.sheets,
        stock.surfaces,
        _LIGHT_OF_BYTE,
        lens,
        depth,
        which,
        surfaces.normal,
        surfaces.albedo,
        surfaces.gloss,
    )
    label = np.zeros(shape, np.uint8)
    bodies = [body for _, body in scene.parts]
    labels = list(range(1, len(bodies) + 1))
    labels += [ITEM_LABEL + i for i in range(len(scene.others))]
    labels += [HAND_LABEL] * len(scene.hand)
    bodies += [*scene.others, *scene.hand]
    _cover(scene, bodies, labels, surfaces, label)
    light = _lit(scene, bodies, surfaces)
    soft = np.empty_like(light)
    stage_kernels.soften_edges(light, label, soft)
    color = _exposed(soft, (label > 0) & (label < ITEM_LABEL), stock, optics, rng)
    return TrainPicture(color, depth, label)


def _cover(
    scene: TrainScene,
    bodies: Sequence[Body],
    labels: Sequence[int],
    surfaces: Surfaces,
    label: Bytes,
) -> None:
    """Draws bodies in front of the room, in place."""
    if not bodies:
        return
    view = scene.camera_from_world
    posed = [(body.mesh, view @ body.world_from_body) for body in bodies]
    seen = render(scene.camera, posed, normals=True)
    if scene.hand and seen.normal is not None:
        smooth_normals(seen.normal, seen.part_id, len(bodies) - len(scene.hand) + 1)
    cover_kernels.put_before(
        surfaces.depth,
        surfaces.normal,
        surfaces.albedo,
        surfaces.gloss,
        label,
        seen.depth,
        seen.normal,
        seen.part_id,
        linear(np.array([body.color_rgb[::-1] for body in bodies], dtype=np.uint8)),
        np.array([body.gloss for body in bodies], dtype=np.float32),
        np.array(labels, dtype=np.uint8),
        np.empty(label.shape, np.uint8),
    )


def _lit(scene: TrainScene, bodies: Sequence[Body], surfaces: Surfaces) -> Singles:
    """(H, W, 3) linear light under all lamps, with their shadows."""
    nothing = np.zeros((1, 1, 3), np.uint8)
    place = Scene(scene.camera, scene.camera_from_world, scene.lamps, scene.ambient, (), nothing)
    views = [LampCamera(lamp, place, _SHADOW_M) for lamp in scene.lamps]
    posed = [(body.mesh, body.world_from_body) for body in bodies]
    maps = [view.shadow(posed) for view in views]
    lamps = kernel_lamps(
        place,
        scene.lamps,
        scene.ambient,
        views,
        np.stack([shadow for shadow, _ in maps]),
        np.stack([cast for _, cast in maps]),
    )
    light: Singles = kernels.shade(
        surfaces.depth,
        surfaces.normal,
        surfaces.albedo,
        surfaces.gloss,
        intrinsics_of(scene.camera),
        np.zeros(2, np.int64),
        lamps,
    )
    return light


def _exposed(
    light: Singles, moving: npt.NDArray[np.bool_], stock: Stock, optics: Optics, rng: Rng
) -> Bytes:
    """The picture as bytes: blur of focus and motion, exposure, noise."""
    if optics.smear_px != (0.0, 0.0):
        streak = _streak(*optics.smear_px)
        if optics.is_shake:
            light = cv2.filter2D(light, -1, streak)
        else:
            light = _smeared(light, moving, streak)
    if optics.focus_px > 0:
        light = cv2.GaussianBlur(light, (0, 0), optics.focus_px)
    mean = float(light[::4, ::4].mean())
    gain = (optics.balance * (optics.brightness / max(mean, 1e-4))).astype(np.float32)
    clean = train_kernels.expose(light, gain, optics.falloff, optics.shoulder, _ENCODING)
    value = np.linspace(0, 1, 256)
    grain = (_READ_NOISE + _SHOT_NOISE * np.sqrt(value) * (1 - 0.5 * value)) * optics.noise
    height, width = clean.shape[:2]
    row = int(rng.integers(stock.noise.shape[0] - height + 1))
    column = int(rng.integers(stock.noise.shape[1] - width + 1))
    noise = stock.noise[row : row + height, column : column + width]
    noisy: Bytes = sensor_kernels.noisy_color(
        clean, noise, (grain / _NOISE_STEPS).astype(np.float32)
    )
    return noisy


def _smeared(light: Singles, moving: npt.NDArray[np.bool_], streak: Singles) -> Singles:
    """Parts that move across a background that rests: both are spread, the one over the other."""
    if not moving.any():
        return light
    there = moving.astype(np.float32)
    rows, columns = np.flatnonzero(moving.any(axis=1)), np.flatnonzero(moving.any(axis=0))
    reach = max(streak.shape)
    window = (
        slice(max(int(rows[0]) - reach, 0), int(rows[-1]) + reach + 1),
        slice(max(int(columns[0]) - reach, 0), int(columns[-1]) + reach + 1),
    )
    there, near = there[window], light[window]
    share = cv2.filter2D(there, -1, streak)[..., None]
    front = cv2.filter2D(near * there[..., None], -1, streak)
    # What is hidden by a part in the middle of the exposure is guessed from what is beside it.
    rest = 1 - there
    side = (2 * reach + 1, 2 * reach + 1)
    around = cv2.blur(rest, side)[..., None]
    guess = cv2.blur(near * rest[..., None], side) / np.maximum(around, 1e-3)
    behind = np.where(there[..., None] > 0, guess, near)
    spread: Singles = light.copy()
    spread[window] = front + (1 - share) * behind
    return spread


def _streak(x_px: float, y_px: float) -> Singles:
    """A kernel along a line, its middle in the middle."""
    n = 2 * math.ceil(max(abs(x_px), abs(y_px)) / 2) + 3
    kernel = np.zeros((n, n), np.float32)
    middle, sixteenth = (n - 1) / 2, 4
    start, end = (
        (
            round((middle + s * x_px / 2) * 2**sixteenth),
            round((middle + s * y_px / 2) * 2**sixteenth),
        )
        for s in (-1, 1)
    )
    cv2.line(kernel, start, end, 1.0, 1, cv2.LINE_AA, sixteenth)
    streak: Singles = kernel / kernel.sum()
    return streak
