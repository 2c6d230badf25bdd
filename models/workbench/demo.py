"""The demo sequence: the scripted assembly of an asset, rendered as a recorded RGB-D sequence."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

import numpy as np
import numpy.typing as npt

from snapfit.models import rasteriser
from snapfit.models.asset import Asset
from snapfit.models.cache import cache_directory
from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import WorkbenchError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.models.workbench.assembly import timed_assembly
from snapfit.models.workbench.mounting import assembly_path
from snapfit.models.workbench.scene import standard_scene
from snapfit.models.workbench.script import Script
from snapfit.models.workbench.sensor import Sensor
from snapfit.models.workbench.shading import Studio
from snapfit.models.workbench.visibility import visibility

FRAME_RATE_HZ = 30.0
_JPEG_QUALITY = 95
_WORKERS = 2
_LAYERS = 3
# How long the assembly is at full speed, frames, and by how much it is slowed to be followed well.
_FIRST_FRAMES, _STEP_FRAMES, _SLOWER = 60, 75, 1.7

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class BenchFrame:
    """One rendered frame.

    Attributes:
        color: (H, W, 3) uint8, blue first.
        depth: (H, W) uint16, mm, 0 is none; aligned with colour.
        truth: poses, visibility and state.
    """

    color: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    truth: GroundTruth


class Workbench:
    """Renders any frame of an asset's scripted assembly; the same seed gives the same bytes.

    Attributes:
        script: who moves when.
        camera: of colour, and of depth in millimetres, aligned with it.

    Raises:
        WorkbenchError: as `timed_assembly`.
    """

    def __init__(self, asset: Asset, seed: int) -> None:
        self._seed = seed
        scene = standard_scene(self._rng(1))
        n_frames = _FIRST_FRAMES + _STEP_FRAMES * len(assembly_path(asset))
        script = timed_assembly(asset, scene, n_frames, seed)
        self.script: Script = script.slowed(_SLOWER)
        self.camera = RgbdCamera(scene.camera, scene.camera)
        self._studio = Studio(scene, asset.parts)
        self._sensor = Sensor(scene.camera, self._rng(2))
        self._layers: dict[bytes, npt.NDArray[np.uint8]] = {}
        self._lock = Lock()
        self._at_rest: dict[int, npt.NDArray[np.uint8]] = {}

    def frame(self, name: str, time_s: float) -> BenchFrame:
        """The bench at one time of the script; may be called from several threads."""
        world_from_part = self.script.poses_at(time_s)
        clean = self._clean(world_from_part, time_s)
        scene = self._studio.scene
        parts = self._studio.parts
        poses = {p.name: scene.camera_from_world @ world_from_part[p.name] for p in parts}
        bodies = [(part.mesh, poses[part.name]) for part in parts]
        seen = rasteriser.render(scene.camera, bodies)
        behind = self._studio.empty_depth
        hidden = (seen.depth == 0) | (seen.depth > behind)
        seen.part_id[hidden] = 0
        shares = visibility(scene.camera, bodies, seen.part_id)
        rng = self._rng(3, round(time_s * 1e6))
        return BenchFrame(
            self._sensor.color(clean, rng),
            self._sensor.depth(np.where(hidden, behind, seen.depth), rng),
            GroundTruth(
                frame=name,
                camera_from_body=poses,
                visibility={p.name: share for p, share in zip(parts, shares, strict=True)},
                state=self.script.state_at(time_s),
            ),
        )

    def _rng(self, *purpose: int) -> np.random.Generator:
        return np.random.default_rng((self._seed, *purpose))

    def _layer(self, standing: Mapping[str, Pose]) -> npt.NDArray[np.uint8]:
        """The picture of what stands; that of the last few arrangements is kept."""
        key = b"".join(name.encode() + pose.matrix.tobytes() for name, pose in standing.items())
        with self._lock:
            if key not in self._layers:
                if len(self._layers) >= _LAYERS:
                    del self._layers[next(iter(self._layers))]
                self._layers[key] = self._studio.layer(standing)
            return self._layers[key]

    def _clean(self, poses: Mapping[str, Pose], time_s: float) -> npt.NDArray[np.uint8]:
        """The picture without noise: a static layer with the parts that move in front."""
        rest = self.script.rest_at(time_s)
        if rest is not None and rest in self._at_rest:
            return self._at_rest[rest]
        moving = self.script.moving_at(time_s)
        standing = {name: pose for name, pose in poses.items() if name not in moving}
        picture = self._layer(standing).copy()
        self._studio.paint(picture, poses, moving)
        if rest is not None:
            self._at_rest[rest] = picture
        return picture


def render_demo(
    directory: Path,
    asset: Asset,
    *,
    n_frames: int | None = None,
    seed: int = 7,
    progress: Progress | None = None,
) -> None:
    """Renders the scripted assembly as a recorded sequence.

    Args:
        directory: made if need be; must not hold a sequence yet.
        asset: bundled, with an assembly graph.
        n_frames: frames from the first moment to the last; 30 a second if None. With fewer the
            parts move faster.
        seed: of the bench's surface, the hand's tremor and the noise.
        progress: called with the share that is done, 0 to 1.

    Raises:
        WorkbenchError: no frames, or the asset has no assembly graph that the bench can play.
        SequenceError: the folder cannot be written, or holds a sequence already.
    """
    if n_frames is not None and n_frames < 1:
        raise WorkbenchError(f"a sequence has at least one frame, n_frames is {n_frames}")
    bench = Workbench(asset, seed)
    n = n_frames or round(bench.script.duration_s * FRAME_RATE_HZ)
    times_s = np.linspace(0, bench.script.duration_s, n)
    names = [f"{i:06d}" for i in range(n)]
    writer = SequenceWriter(
        directory,
        bench.camera,
        frame_rate_hz=FRAME_RATE_HZ,
        asset=asset.name,
        jpeg_quality=_JPEG_QUALITY,
        note=f"simulated workbench, seed {seed}",
    )
    with writer, ThreadPoolExecutor(_WORKERS) as pool:
        ahead = 2 * _WORKERS
        waiting = [
            pool.submit(bench.frame, *job) for job in zip(names[:ahead], times_s, strict=False)
        ]
        for i, name in enumerate(names):
            frame = waiting.pop(0).result()
            if i + ahead < n:
                waiting.append(pool.submit(bench.frame, names[i + ahead], times_s[i + ahead]))
            writer.write(name, frame.color, frame.depth, frame.truth)
            if progress:
                progress((i + 1) / n)


def demo_sequence(asset: Asset, progress: Progress | None = None) -> Path:
    """The folder of the rendered demo sequence of an asset; rendered once, then taken from cache.

    Args:
        asset: as in `render_demo`.
        progress: called with the share that is done, 0 to 1; not at all when it is there already.

    Raises:
        WorkbenchError: as `render_demo`.
        OSError: the cache cannot be written.
    """
    folder = cache_directory() / "demo"
    goal = folder / f"{asset.name}-{_digest(asset)}"
    if goal.is_dir():
        return goal
    folder.mkdir(exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=".draft-", dir=folder))
    try:
        render_demo(draft, asset, progress=progress)
        try:
            draft.rename(goal)
        except OSError:
            # Another process was faster; what it made is the same.
            if not goal.is_dir():
                raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    return goal


def _digest(asset: Asset) -> str:
    """Changes with whatever the rendering depends on: the asset and this package's code."""
    sha = hashlib.sha256()
    for part in asset.parts:
        sha.update(f"{part.name}{part.color_rgb}{part.mesh.digest}".encode())
    sha.update(f"{asset.states}{asset.steps}".encode())
    code = [*Path(__file__).parent.glob("*.py"), Path(rasteriser.__file__)]
    for path in sorted(code):
        sha.update(path.read_bytes())
    return sha.hexdigest()[:16]
