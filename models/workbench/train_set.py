"""The training split: images for the keypoint network, each from its own seed, on all cores.

Image i of a set is the same whatever else is rendered with it, and with however many processes:
all its randomness comes from (seed, asset, i). Even ones show parts joined as some state of the
assembly graph has them, odd ones show all parts apart.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset, find_asset
from snapfit.models.bop_writer import write_models
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import N_KEYPOINTS, KeypointModel, keypoint_models
from snapfit.models.train_labels import TRAIN, Labels
from snapfit.models.train_writer import TrainWriter
from snapfit.models.ultralytics_layout import write_ultralytics
from snapfit.models.workbench.fan_out import asset_digest, claim_folder, fan_out
from snapfit.models.workbench.sensor import Sensor
from snapfit.models.workbench.train_modules import Modules
from snapfit.models.workbench.train_picture import Optics, TrainPicture, drawn
from snapfit.models.workbench.train_scene import STANDARD_CAMERA, sampled_scene
from snapfit.models.workbench.train_stock import Stock, stock_for
from snapfit.models.workbench.train_truth import labels_of

N_IMAGES = 15_000
_RECIPE = 1
_RUN_IMAGES = 25

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class TrainOrder:
    """What is to be rendered.

    Attributes:
        directory: of the dataset.
        assets: names of bundled assets, or their folders.
        count: images an asset.
        seed: of everything.
        depth: whether to write depth too.
        masks: whether to write masks as PNG files beside the run lengths.
        n_keypoints: a part.
        scale: share of 960x540.
    """

    directory: Path
    assets: tuple[str, ...]
    count: int = N_IMAGES
    seed: int = 20
    depth: bool = False
    masks: bool = False
    n_keypoints: int = N_KEYPOINTS
    scale: float = 1.0


@dataclass(frozen=True)
class TrainRun:
    """Some images of one asset."""

    order: TrainOrder
    asset: str
    indices: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Workshop:
    """What a process needs for an asset."""

    asset: Asset
    modules: Modules
    stock: Stock
    models: dict[str, KeypointModel]
    sensor: Sensor


def render_train_set(
    order: TrainOrder,
    *,
    jobs: int = -1,
    backend: str = "loky",
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Renders what is missing of the sets, and puts their files together.

    Args:
        order: what is wanted.
        jobs: processes; -1 is one a core.
        backend: joblib's: loky, ray or dask.
        progress: called with images that are there and images wanted.

    Returns:
        Figures: images, megabytes and instances by asset, and what this run made, how fast.

    Raises:
        ManifestError: there is no such asset.
        DatasetError: the folder holds another set, the disk is full, an asset has no tracked part,
            or the backend is not installed.
    """
    started_s = time.perf_counter()
    assets = {name: find_asset(name) for name in order.assets}
    for asset in assets.values():
        _prepare(order, asset)
    runs = [run for name, asset in assets.items() for run in _runs(order, name, asset)]
    wanted = order.count * len(assets)
    missing = sum(len(run.indices) for run in runs)
    made = 0
    if progress:
        progress(wanted - missing, wanted)
    for count in fan_out(render_train_run, runs, jobs, backend):
        made += count
        if progress:
            progress(wanted - missing + made, wanted)
    figures = {asset.name: _finished(order, asset) for asset in assets.values()}
    wall_s = time.perf_counter() - started_s
    return {
        "assets": figures,
        "last_rendering": {
            "images": made,
            "seconds": round(wall_s, 1),
            "images_per_second": round(made / wall_s, 1),
        },
    }


def render_train_run(run: TrainRun) -> int:
    """Renders some images; what another process needs nothing else for. Returns their number.

    Raises:
        DatasetError: as `render_train_set`.
    """
    order = run.order
    shop = _workshop(run.asset, order.seed, order.n_keypoints, order.scale)
    writer = TrainWriter(order.directory / shop.asset.name)
    for index in run.indices:
        labels, picture, measured, quality = _image(shop, order, index)
        depth = measured if order.depth else None
        writer.write(labels, picture.color, quality, depth, order.masks)
    return len(run.indices)


def _image(
    shop: _Workshop, order: TrainOrder, index: int
) -> tuple[Labels, TrainPicture, npt.NDArray[np.uint16], int]:
    rng = np.random.default_rng((order.seed, _asset_number(shop.asset), index))
    assembled = index % 2 == 0 and shop.modules.can_be_assembled
    scene = sampled_scene(shop.asset, shop.modules, shop.stock, assembled, rng, order.scale)
    picture = drawn(scene, shop.stock, Optics.sampled(rng, order.scale), rng)
    if order.depth:
        measured = shop.sensor.depth(picture.depth, rng)
    else:
        measured = (picture.depth * 1000 + 0.5).astype(np.uint16)
    labels = labels_of(index, scene, picture, shop.models, measured)
    return labels, picture, measured, int(rng.integers(62, 94))


@lru_cache(maxsize=1)
def _workshop(name: str, seed: int, n_keypoints: int, scale: float) -> _Workshop:
    asset = find_asset(name)
    camera = STANDARD_CAMERA if scale == 1.0 else STANDARD_CAMERA.scaled(scale)
    return _Workshop(
        asset,
        Modules(asset),
        stock_for(asset.name, seed),
        {model.name: model for model in keypoint_models(asset.tracked_parts, n_keypoints)},
        Sensor(camera, np.random.default_rng((seed, 0xDE9))),
    )


def _asset_number(asset: Asset) -> int:
    """Another stream of random numbers for each asset."""
    return int.from_bytes(hashlib.sha256(asset.name.encode()).digest()[:4], "big")


def _prepare(order: TrainOrder, asset: Asset) -> None:
    if not asset.tracked_parts:
        raise DatasetError(asset.directory, "the asset has no tracked part to be learnt")
    recipe = {
        "asset": asset.name,
        "digest": asset_digest(asset),
        "seed": order.seed,
        "scale": order.scale,
        "keypoints": order.n_keypoints,
        "depth": order.depth,
        "masks": order.masks,
        "recipe": _RECIPE,
    }
    claim_folder(order.directory / asset.name / TRAIN, recipe)
    write_models(order.directory / asset.name / "models", asset)


def _runs(order: TrainOrder, name: str, asset: Asset) -> list[TrainRun]:
    there = TrainWriter(order.directory / asset.name).finished()
    missing = [index for index in range(order.count) if index not in there]
    return [
        TrainRun(order, name, tuple(missing[i : i + _RUN_IMAGES]))
        for i in range(0, len(missing), _RUN_IMAGES)
    ]


def _finished(order: TrainOrder, asset: Asset) -> dict[str, Any]:
    """Writes the scenes' own files and the Ultralytics layout; returns the set's figures."""
    folder = order.directory / asset.name
    writer = TrainWriter(folder)
    models = keypoint_models(asset.tracked_parts, order.n_keypoints)
    ordered = writer.finish(models, asset.name, f"simulated workbench, seed {order.seed}")
    write_ultralytics(folder, writer.folder, ordered, models)
    files = (path for path in writer.folder.rglob("*") if path.is_file())
    megabytes = sum(path.stat().st_size for path in files) / 1e6
    return {
        "images": len(ordered),
        "assembled": sum(labels.is_assembled for labels in ordered),
        "instances": sum(len(labels.instances) for labels in ordered),
        "mean_visibility": _mean_visibility(ordered),
        "megabytes": round(megabytes, 1),
    }


def _mean_visibility(ordered: Sequence[Labels]) -> float:
    shares = [each.visibility for labels in ordered for each in labels.instances]
    return round(float(np.mean(shares)), 3) if shares else 0.0
