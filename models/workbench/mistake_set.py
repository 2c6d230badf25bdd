"""The split of mistakes on disk: ASSET/mistakes/NUMBER in BOP's format, made on all cores.

Sequence i is the same however many are made: assets, kinds of mistake and conditions come in turn,
and all its randomness comes from (seed, i). What is finished is kept.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from snapfit.models.asset import Asset, find_asset
from snapfit.models.bop_writer import BopWriter, write_models
from snapfit.models.workbench.bench import sampled_scene
from snapfit.models.workbench.dataset import frame_entry
from snapfit.models.workbench.fan_out import asset_digest, claim_folder, fan_out
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.mistake import (
    MISTAKE_NAME,
    SPLIT,
    Mistake,
    MistakeFolder,
    MistakeKind,
    read_mistake,
    write_mistake,
)
from snapfit.models.workbench.mistakes import MistakeMaker, n_frames_of
from snapfit.models.workbench.split import FRAME_RATE_HZ, Condition

N_SEQUENCES = 64
_RECIPE = 1
_SEEDS = 100_000

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class MistakeOrder:
    """What is to be rendered.

    Attributes:
        directory: of the dataset.
        assets: names of bundled assets, or their folders; in turn.
        count: sequences.
        conditions: in turn, too.
        seed: of everything.
        scale: share of 1280x720.
    """

    directory: Path
    assets: tuple[str, ...]
    count: int = N_SEQUENCES
    conditions: tuple[Condition, ...] = (Condition.NORMAL,)
    seed: int = 20
    scale: float = 1.0


@dataclass(frozen=True)
class MistakeRun:
    """One sequence."""

    order: MistakeOrder
    index: int

    @property
    def asset(self) -> str:
        """Name or folder of the asset."""
        return self.order.assets[self.index % len(self.order.assets)]

    @property
    def kind(self) -> MistakeKind:
        """The kind that is wanted: all of them for each asset, and others for the next."""
        i, n = self.index, len(self.order.assets)
        kinds = list(MistakeKind)
        return kinds[(i // n + i % n) % len(kinds)]

    @property
    def condition(self) -> Condition:
        """Under which it is rendered."""
        i, n = self.index, len(self.order.assets) * len(MistakeKind)
        return self.order.conditions[i // n % len(self.order.conditions)]

    @property
    def seed(self) -> int:
        """Of this sequence alone."""
        return _SEEDS * self.order.seed + self.index


def render_mistakes(
    order: MistakeOrder,
    *,
    jobs: int = -1,
    backend: str = "loky",
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Renders what is missing of the sequences.

    Args:
        order: what is wanted.
        jobs: processes; -1 is one a core.
        backend: joblib's: loky, ray or dask.
        progress: called with sequences that are there and sequences wanted.

    Returns:
        `sequences`: of each, asset and mistake; `frames` and `seconds` of this rendering.

    Raises:
        ManifestError: there is no such asset.
        WorkbenchError: an asset that cannot be put together, or nothing of it wrongly.
        DatasetError: the folder holds another rendering, the disk is full, or the backend is not
            installed.
    """
    started_s = time.perf_counter()
    assets = {name: find_asset(name) for name in order.assets}
    for asset in assets.values():
        write_models(order.directory / asset.name / "models", asset)
    runs = [MistakeRun(order, i) for i in range(order.count)]
    for run in runs:
        _claim(run, assets[run.asset])
    missing = [run for run in runs if not _is_finished(run, assets[run.asset])]
    there, n_frames = len(runs) - len(missing), 0
    if progress:
        progress(there, len(runs))
    for made in fan_out(render_mistake, missing, jobs, backend):
        there, n_frames = there + 1, n_frames + made
        if progress:
            progress(there, len(runs))
    sequences = list(_sequences(runs, assets))
    seconds = round(time.perf_counter() - started_s, 1)
    return {"sequences": sequences, "frames": n_frames, "seconds": seconds}


def render_mistake(run: MistakeRun) -> int:
    """Renders what is missing of one sequence; returns how many frames that was.

    Raises:
        WorkbenchError, DatasetError: as `render_mistakes`.
    """
    asset = find_asset(run.asset)
    scene = sampled_scene(run.seed, [part.color_rgb for part in asset.parts])
    script, mistake = MistakeMaker(asset, scene, run.seed).make(run.kind)
    n_frames = n_frames_of(script)
    film = Film(asset, n_frames, run.seed, run.order.scale, script)
    folder = mistake_folder(run, asset)
    writer = BopWriter(folder, film.camera)
    missing = sorted(set(range(n_frames)) - writer.finished())
    for index in missing:
        frame = film.frame(index, run.condition)
        masks = [each.mask for each in frame.sightings.values()]
        writer.write(index, frame.color, frame.depth, masks, frame_entry(asset, frame))
    note = f"simulated workbench, {mistake.kind}, {run.condition}, seed {run.order.seed}"
    writer.finish(asset, FRAME_RATE_HZ, note)
    write_mistake(folder, mistake)
    return len(missing)


def mistake_folder(run: MistakeRun, asset: Asset) -> Path:
    """Where a sequence lies."""
    return run.order.directory / asset.name / SPLIT / f"{run.index:06d}"


def _claim(run: MistakeRun, asset: Asset) -> None:
    """Refuses a folder that holds something else."""
    recipe = {
        "asset": asset.name,
        "digest": asset_digest(asset),
        "kind": run.kind,
        "condition": run.condition,
        "seed": run.seed,
        "scale": run.order.scale,
        "recipe": _RECIPE,
    }
    claim_folder(mistake_folder(run, asset), recipe)


def _is_finished(run: MistakeRun, asset: Asset) -> bool:
    return (mistake_folder(run, asset) / MISTAKE_NAME).is_file()


def _sequences(
    runs: list[MistakeRun], assets: dict[str, Asset]
) -> Iterator[tuple[MistakeFolder, Mistake]]:
    for run in runs:
        asset = assets[run.asset]
        folder = mistake_folder(run, asset)
        yield MistakeFolder(asset.name, folder), read_mistake(folder)
