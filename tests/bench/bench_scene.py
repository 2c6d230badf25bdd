"""A scene for the tracker's benchmark: clamp parts in motion, overlapping one another."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part, find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.frame import Frame

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
BENCH_DEPTH_M = 0.95
_STEP_M = 0.003
_STEP_DEG = 1.5


@dataclass(frozen=True, eq=False)
class Scene:
    """Frames with known poses.

    Attributes:
        parts: what moves.
        frames: 1280x720 colour and aligned depth.
        poses: for each frame the true pose `camera_from_body` of each part.
    """

    parts: tuple[Part, ...]
    frames: tuple[Frame, ...]
    poses: tuple[dict[str, Pose], ...]


def make_scene(n_parts: int, n_frames: int, seed: int = 0) -> Scene:
    """`n_parts` clamp parts side by side, near enough that their images overlap.

    Every part moves by 3 mm and 1.5 degrees a frame, to and fro.
    """
    rng = np.random.default_rng(seed)
    clamp = find_asset("hobby-corner-clamp").tracked_parts
    parts = tuple(
        replace(clamp[i % len(clamp)], name=f"{clamp[i % len(clamp)].name}-{i}")
        for i in range(n_parts)
    )
    homes = [_home(i, n_parts, rng) for i in range(n_parts)]
    swings = [rng.normal(size=6) for _ in parts]
    background = rng.integers(90, 140, (720, 1280, 3), dtype=np.uint8)
    frames, poses = [], []
    for k in range(n_frames):
        phase = abs((k % 16) - 8) - 4
        now = {
            part.name: home.perturbed(_swing(swing, phase))
            for part, home, swing in zip(parts, homes, swings, strict=True)
        }
        frames.append(_draw(str(k), parts, now, background, rng))
        poses.append(now)
    return Scene(parts, tuple(frames), tuple(poses))


def _home(i: int, n_parts: int, rng: np.random.Generator) -> Pose:
    column, row = i % 4, i // 4
    columns = min(n_parts, 4)
    place = (0.13 * (column - (columns - 1) / 2), 0.12 * row - 0.05, 0.68 + 0.03 * (i % 2))
    return Pose.from_rotation_translation(
        Pose.exp([*rng.normal(size=3) * 0.8, 0, 0, 0]).rotation, place
    )


def _swing(direction: npt.NDArray[np.float64], phase: float) -> npt.NDArray[np.float64]:
    turn, move = direction[:3], direction[3:]
    turn = turn / np.linalg.norm(turn) * np.radians(_STEP_DEG)
    return np.concatenate([turn, move / np.linalg.norm(move) * _STEP_M]) * phase


def _draw(
    name: str,
    parts: tuple[Part, ...],
    poses: dict[str, Pose],
    background: npt.NDArray[np.uint8],
    rng: np.random.Generator,
) -> Frame:
    seen = render(CAMERA.color, [(part.mesh, poses[part.name]) for part in parts], normals=True)
    if seen.normal is None:
        raise RuntimeError("the rasteriser gave no normals")
    colors = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in parts)], dtype=np.float32)
    light = 0.5 + 0.5 * np.abs(seen.normal[..., 2:])
    noise = rng.normal(0, 4, (720, 1280, 1)).astype(np.float32)
    lit = np.clip(colors[seen.part_id] * light + noise, 0, 255).astype(np.uint8)
    color = np.where(seen.part_id[..., None] > 0, lit, background)
    depth_m = np.where(seen.depth > 0, seen.depth, np.float32(BENCH_DEPTH_M))
    depth = np.round((depth_m + rng.normal(0, 0.001, depth_m.shape)) * 1000).astype(np.uint16)
    return Frame(name, 0, np.ascontiguousarray(color), depth)
