"""What a rendered dataset is like, measured on what was written: motion, visibility, throughput."""

from __future__ import annotations

import itertools
import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from snapfit.models.pose import Pose
from snapfit.models.workbench.speed import summarised
from snapfit.models.workbench.split import EFFECTS, Condition

SUMMARY_NAME = "summary.json"
_HIDDEN, _STRETCH = 0.15, 15
_STILL = 0.05


def scene_summary(
    folder: Path,
    entries: Mapping[int, Mapping[str, Any]],
    condition: Condition,
    took: tuple[float, int],
) -> dict[str, Any]:
    """Figures of one scene.

    Args:
        folder: of the scene.
        entries: of all its frames, in order.
        condition: under which it was rendered.
        took: seconds of one core, and frames rendered in them.
    """
    frames = list(entries.values())
    speed = summarised(_steps(frames), len(frames))
    seen = [_visibility_in_hand(frame) for frame in frames]
    known = [share for share in seen if share is not None]
    figures = {
        "frames": len(frames),
        "motion": {name: round(value, 3) for name, value in asdict(speed).items()},
        "exposure_share": EFFECTS[condition].exposure,
        "visibility_in_hand": round(float(np.mean(known)), 3) if known else None,
        "hidden_stretches": hidden_stretches(seen),
        "states": list(dict.fromkeys(frame["state"] for frame in frames)),
        "megabytes": round(_size_bytes(folder) / 1e6, 1),
    }
    if took[1]:
        figures["frames_per_core_second"] = round(took[1] / max(took[0], 1e-6), 2)
    return figures


def hidden_stretches(seen: Sequence[float | None]) -> list[int]:
    """Lengths of all runs of 15 frames or more with less than 15 % of the moving part in view."""
    runs = itertools.groupby(share is not None and share < _HIDDEN for share in seen)
    lengths = [(hidden, len(list(run))) for hidden, run in runs]
    return [length for hidden, length in lengths if hidden and length >= _STRETCH]


def merged_summary(
    directory: Path,
    seed: int,
    scenes: Mapping[str, dict[str, Any]],
    made: tuple[int, float, int, str],
) -> dict[str, Any]:
    """The dataset's summary: scenes of earlier renderings are kept.

    Args:
        directory: of the dataset.
        seed: of the rendering.
        scenes: figures by scene, of this rendering.
        made: frames rendered now, seconds that took, jobs, backend.
    """
    try:
        old = json.loads((directory / SUMMARY_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        old = {}
    all_scenes = dict(old.get("scenes", {}))
    for name, figures in scenes.items():
        speed = all_scenes.get(name, {}).get("frames_per_core_second")
        kept = {} if speed is None else {"frames_per_core_second": speed}
        all_scenes[name] = kept | figures
    n_made, wall_s, jobs, backend = made
    last = {
        "frames": n_made,
        "seconds": round(wall_s, 1),
        "frames_per_second": round(n_made / wall_s, 2) if n_made else 0.0,
        "jobs": jobs,
        "backend": backend,
    }
    return {
        "seed": seed,
        "machine": {"processor": platform.machine(), "cores": os.cpu_count()},
        "frames": sum(each["frames"] for each in all_scenes.values()),
        "megabytes": round(sum(each["megabytes"] for each in all_scenes.values()), 1),
        "last_rendering": last if n_made else old.get("last_rendering", last),
        "scenes": all_scenes,
    }


def _steps(frames: Sequence[Mapping[str, Any]]) -> list[tuple[float, float]]:
    """(mm, deg) from frame to frame of the part in hand, where it moves."""
    steps = []
    for before, now in itertools.pairwise(frames):
        part = now["in_hand"]
        if part is None or part not in now["poses"]:
            continue
        a, b = (Pose(np.array(frame["poses"][part])) for frame in (before, now))
        step = (a.distance_to(b) * 1000, float(np.degrees(a.angle_to(b))))
        if max(step) > _STILL:
            steps.append(step)
    return steps


def _visibility_in_hand(frame: Mapping[str, Any]) -> float | None:
    share: float | None = frame["visib"].get(frame["in_hand"])
    return share


def _size_bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
