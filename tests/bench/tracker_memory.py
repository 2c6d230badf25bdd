"""Memory of a process that tracks and does nothing else: python tracker_memory.py DIRECTORY

The frames are rendered before, by the process that asks; this one reads them from files, as a
server reads them from a camera.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from bench_scene import CAMERA

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker

_STATUS = Path("/proc/self/status")


def memory_mb(
    directory: Path,
    asset: str,
    frames: Sequence[Frame],
    poses: Mapping[str, Pose],
    state: str,
) -> float:
    """Most memory of a process that tracks an asset's parts through frames, MB.

    Args:
        directory: for the frames, empty.
        asset: name of the asset.
        frames: what is tracked through, by the camera of `bench_scene`.
        poses: `camera_from_body` of each part in the first frame.
        state: of the assembly there.
    """
    for index, frame in enumerate(frames):
        np.savez(directory / f"{index:04d}.npz", color=frame.color, depth=frame.depth)
    start = {name: pose.matrix.tolist() for name, pose in poses.items()}
    told = {"asset": asset, "state": state, "poses": start, "n_frames": len(frames)}
    (directory / "start.json").write_text(json.dumps(told))
    command = [sys.executable, __file__, str(directory)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return float(done.stdout)


def track(directory: Path) -> float:
    """Track through the frames of a directory; returns the most memory of this process, MB."""
    told = json.loads((directory / "start.json").read_text())
    asset = find_asset(told["asset"])
    tracker = create_tracker("gbot", asset.tracked_parts, CAMERA, asset=asset)
    for index in range(told["n_frames"]):
        with np.load(directory / f"{index:04d}.npz") as images:
            frame = Frame(str(index), index * 33_333_333, images["color"], images["depth"])
        if index == 0:
            tracker.start(frame, {name: Pose(matrix) for name, matrix in told["poses"].items()})
            tracker.set_state(told["state"])
        tracker.track(frame)
    # Not `ru_maxrss`: a child begins with that of its parent.
    line = next(row for row in _STATUS.read_text().splitlines() if row.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


if __name__ == "__main__":
    sys.stdout.write(f"{track(Path(sys.argv[1]))}\n")
