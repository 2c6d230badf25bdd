"""The simulated dataset on disk: ASSET/test/CONDITION in BOP's format, made on all cores.

Work is cut into runs of consecutive frames, each rendered under all conditions at once, because
these share what stands on the bench. Finished frames are kept: the same call goes on where an
earlier one ended.
"""

from __future__ import annotations

import json
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from snapfit.models.asset import Asset, find_asset
from snapfit.models.bop_writer import (
    BopWriter,
    instance,
    write_models,
    write_text,
)
from snapfit.models.errors import DatasetError
from snapfit.models.workbench.blender import check_bpy
from snapfit.models.workbench.cycles import CyclesFilm
from snapfit.models.workbench.fan_out import asset_digest, claim_folder, fan_out
from snapfit.models.workbench.film import Film, FilmFrame
from snapfit.models.workbench.split import FRAME_RATE_HZ, TEST_FRAMES, Condition
from snapfit.models.workbench.summary import SUMMARY_NAME, merged_summary, scene_summary

_RECIPE = 2
_RUN_FRAMES = 40

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Order:
    """What is to be rendered.

    Attributes:
        directory: of the dataset.
        assets: names of bundled assets, or their folders.
        conditions: of each asset.
        seed: of everything.
        limit: only the first frames of each scene; None is all.
        scale: share of 1280x720.
        cycles_samples: paths of light a pixel, by Blender's Cycles; None is the own renderer.
    """

    directory: Path
    assets: tuple[str, ...] = tuple(TEST_FRAMES)
    conditions: tuple[Condition, ...] = tuple(Condition)
    seed: int = 20
    limit: int | None = None
    scale: float = 1.0
    cycles_samples: int | None = None


@dataclass(frozen=True)
class Run:
    """Some frames of one asset, and for each condition those that are missing."""

    order: Order
    asset: str
    n_frames: int
    missing: tuple[tuple[Condition, tuple[int, ...]], ...]


@dataclass(frozen=True)
class RunReport:
    """What a run took.

    Attributes:
        asset: its name.
        counts: frames rendered, by condition.
        seconds: of one core, by condition.
    """

    asset: str
    counts: dict[Condition, int]
    seconds: dict[Condition, float]


def render_dataset(
    order: Order,
    *,
    jobs: int = -1,
    backend: str = "loky",
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Renders what is missing of a dataset, and sums it up in `summary.json`.

    Args:
        order: what is wanted.
        jobs: processes; -1 is one a core.
        backend: joblib's: loky (processes here), ray or dask (a cluster that is running).
        progress: called with frames that are there and frames wanted.

    Returns:
        The content of `summary.json`.

    Raises:
        ManifestError: there is no such asset.
        WorkbenchError: an asset that the workbench cannot put together; Blender is wanted and not
            installed.
        DatasetError: an asset is not in the split, the folder holds another rendering, the disk
            is full, or the backend is not installed.
    """
    started_s = time.perf_counter()
    if order.cycles_samples is not None:
        check_bpy()
    assets = {name: find_asset(name) for name in order.assets}
    for asset in assets.values():
        _prepare(order, asset)
    runs = [run for name, asset in assets.items() for run in _runs(order, name, asset)]
    wanted = sum(_n_frames(order, asset) * len(order.conditions) for asset in assets.values())
    there = wanted - sum(len(missing) for run in runs for _, missing in run.missing)
    if progress:
        progress(there, wanted)
    counts: Counter[tuple[str, Condition]] = Counter()
    seconds: defaultdict[tuple[str, Condition], float] = defaultdict(float)
    for report in fan_out(render_run, runs, jobs, backend):
        for condition, count in report.counts.items():
            counts[report.asset, condition] += count
            seconds[report.asset, condition] += report.seconds[condition]
        there += sum(report.counts.values())
        if progress:
            progress(there, wanted)
    scenes = {}
    for name, asset in assets.items():
        for condition in order.conditions:
            took_s = seconds[name, condition], counts[name, condition]
            scenes[f"{asset.name}/{condition}"] = _finished(order, asset, condition, took_s)
    wall_s = time.perf_counter() - started_s
    made = sum(counts.values())
    summary = merged_summary(order.directory, order.seed, scenes, (made, wall_s, jobs, backend))
    write_text(order.directory / SUMMARY_NAME, json.dumps(summary, indent=1) + "\n")
    return summary


def scene_folder(order: Order, asset: Asset, condition: Condition) -> Path:
    """Where a scene lies."""
    return order.directory / asset.name / "test" / condition


def asset_seed(order: Order, asset: Asset) -> int:
    """Another bench, other ways and another hand for each asset."""
    names = list(TEST_FRAMES)
    own = names.index(asset.name) if asset.name in names else len(names)
    return 100 * order.seed + own


def _whole_length(asset: Asset) -> int:
    if asset.name not in TEST_FRAMES:
        known = ", ".join(TEST_FRAMES)
        raise DatasetError(
            asset.directory, f"{asset.name!r} is not in the test split, which has: {known}"
        )
    return TEST_FRAMES[asset.name]


def _n_frames(order: Order, asset: Asset) -> int:
    return min(_whole_length(asset), order.limit or _whole_length(asset))


def _prepare(order: Order, asset: Asset) -> None:
    """Folders and meshes; refuses a folder that holds something else."""
    _whole_length(asset)
    recipe = {
        "asset": asset.name,
        "digest": asset_digest(asset),
        "seed": order.seed,
        "scale": order.scale,
        "recipe": _RECIPE,
    }
    if order.cycles_samples is not None:
        recipe["cycles_samples"] = order.cycles_samples
    for condition in order.conditions:
        claim_folder(scene_folder(order, asset, condition), recipe)
    write_models(order.directory / asset.name / "models", asset)


def _runs(order: Order, name: str, asset: Asset) -> Iterator[Run]:
    n = _n_frames(order, asset)
    camera = Film.camera_of(order.scale)
    there = {
        condition: BopWriter(scene_folder(order, asset, condition), camera).finished()
        for condition in order.conditions
    }
    for start in range(0, n, _RUN_FRAMES):
        frames = range(start, min(start + _RUN_FRAMES, n))
        missing = tuple(
            (condition, tuple(i for i in frames if i not in there[condition]))
            for condition in order.conditions
        )
        if any(indices for _, indices in missing):
            yield Run(order, name, _whole_length(asset), missing)


def render_run(run: Run) -> RunReport:
    """Renders some frames; what another process needs nothing else for.

    Raises:
        DatasetError: as `render_dataset`.
    """
    asset, film = _film(run.asset, run.n_frames, run.order)
    counts, seconds = {}, {}
    for condition, indices in run.missing:
        started_s = time.perf_counter()
        writer = BopWriter(scene_folder(run.order, asset, condition), film.camera)
        for index in indices:
            frame = film.frame(index, condition)
            masks = [each.mask for each in frame.sightings.values()]
            writer.write(index, frame.color, frame.depth, masks, frame_entry(asset, frame))
        counts[condition] = len(indices)
        seconds[condition] = time.perf_counter() - started_s
    return RunReport(run.asset, counts, seconds)


@lru_cache(maxsize=1)
def _film(name: str, n_frames: int, order: Order) -> tuple[Asset, Film]:
    """Kept, because a process gets run after run of the same asset."""
    asset = find_asset(name)
    seed, samples = asset_seed(order, asset), order.cycles_samples
    if samples is None:
        return asset, Film(asset, n_frames, seed, order.scale)
    return asset, CyclesFilm(asset, n_frames, seed, order.scale, samples=samples)


def frame_entry(asset: Asset, frame: FilmFrame) -> dict[str, Any]:
    """What `BopWriter.write` is told of a frame."""
    parts = {part.name: part for part in asset.parts}
    sightings = frame.sightings
    return {
        "gt": [instance(parts[name], each.camera_from_body) for name, each in sightings.items()],
        "info": [
            {
                "bbox_obj": each.box,
                "bbox_visib": each.box_seen,
                "px_count_all": each.n_pixels,
                "px_count_valid": each.n_measured,
                "px_count_visib": each.n_seen,
                "visib_fract": round(each.visibility, 6),
            }
            for each in sightings.values()
        ],
        "poses": {name: each.camera_from_body.matrix.tolist() for name, each in sightings.items()},
        "visib": {name: round(each.visibility, 6) for name, each in sightings.items()},
        "state": frame.state,
        "in_hand": frame.in_hand,
    }


def _finished(
    order: Order, asset: Asset, condition: Condition, took: tuple[float, int]
) -> dict[str, Any]:
    """Writes the scene's own files; returns its figures."""
    folder = scene_folder(order, asset, condition)
    writer = BopWriter(folder, Film.camera_of(order.scale))
    note = f"simulated workbench, {condition}, seed {order.seed}"
    writer.finish(asset, FRAME_RATE_HZ, note)
    return scene_summary(folder, writer.entries(), condition, took)
