"""A station that is recorded: parts that move before a camera, and a network that finds them."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tracking" / "detection"))

import fake_network
import numpy as np

from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.server.open_pipeline import open_pipeline
from snapfit.server.pipeline import Pipeline
from snapfit.server.worker_spec import WorkerSpec

N_FRAMES = 24
MOST_WAITING = 10
STEP = Pose.exp([0.0015, -0.002, 0.001, 0.0004, -0.0002, 0.0003])


def write_moving(folder: Path, n_frames: int = N_FRAMES) -> Path:
    """Two parts that go a little further with each frame, from where the network sees them."""
    camera = fake_network.RGBD
    rng = np.random.default_rng(8)
    wall = rng.integers(100, 160, (camera.color.height, camera.color.width, 1))
    poses = dict(fake_network.POSES)
    colors = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in fake_network.PARTS)], float)
    writer = SequenceWriter(
        folder, camera, asset="hobby-corner-clamp", initial_poses={}, color_format="png"
    )
    with writer:
        for number in range(n_frames):
            parts = [(part.mesh, poses[part.name]) for part in fake_network.PARTS]
            seen = render(camera.color, parts, normals=True)
            assert seen.normal is not None
            body = colors[seen.part_id] * (0.5 + 0.5 * np.abs(seen.normal[..., 2:]))
            color = np.where(seen.part_id[..., None] > 0, body, wall * np.ones(3))
            pixels = np.clip(color + rng.normal(0, 3, color.shape), 0, 255).astype(np.uint8)
            depth = np.where(seen.depth > 0, seen.depth, 0.9) / camera.depth_scale_m
            noisy = np.rint(depth + rng.normal(0, 1.5, depth.shape)).astype(np.uint16)
            writer.write(f"{number:06d}", pixels, noisy)
            poses = {name: pose @ STEP for name, pose in poses.items()}
    return folder


def opened(source: Path, asset: Path | str, record: Path | None, **given: str) -> Pipeline:
    """The pipeline of a station that is recorded into a folder."""
    spec = WorkerSpec(
        station="bench",
        source=str(source),
        asset=str(asset),
        boot_id="",
        wall_minus_monotonic_ns=0,
        poses_segment="",
        pictures_segment="",
        record=None if record is None else str(record),
        **{"method": "gbot", "detector": "network", **given},
    )
    return open_pipeline(spec, lambda _text, _share: None)


def play(pipeline: Pipeline, n_frames: int, pause_s: float = 0.0) -> int:
    """Tracks so many frames, as the worker's loop does; how many poses came out.

    All of them are written: a recorder that is held up is waited for.
    """
    stop, n_poses = threading.Event(), 0
    for _ in range(n_frames):
        frame = pipeline.source.read()
        assert frame is not None
        result = pipeline.tracker.track(frame)
        n_poses += sum(each.camera_from_body is not None for each in result.parts)
        stop.wait(pause_s)
        while _images_waiting(pipeline) > MOST_WAITING:
            stop.wait(0.01)
    return n_poses


def _images_waiting(pipeline: Pipeline) -> int:
    waiting: int = pipeline.recording._recording._n_images  # type: ignore[union-attr]
    return waiting


def main() -> None:
    """Records until it is killed; says how many frames are written and how many poses there are."""
    source, asset, record = (Path(each) for each in sys.argv[1:4])
    pipeline = opened(source, asset, record)
    assert pipeline.recording is not None
    n_poses = 0
    for _ in range(2000):
        # Until they are found, which takes a busy machine its time, frames only fill the file.
        n_poses += play(pipeline, 1, pause_s=0.02 if n_poses else 0.1)
        os.write(1, f"{pipeline.recording.account.frames} {n_poses}\n".encode())


if __name__ == "__main__":
    main()
