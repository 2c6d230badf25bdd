"""Work spread over cores or a cluster by joblib, and folders that hold one rendering each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from snapfit.models.asset import Asset
from snapfit.models.bop_writer import make_folder, write_text
from snapfit.models.errors import DatasetError

RENDERING_NAME = "rendering.json"

Run = TypeVar("Run")
Report = TypeVar("Report")


def fan_out(
    render_run: Callable[[Run], Report], runs: Sequence[Run], jobs: int, backend: str
) -> Iterator[Report]:
    """Renders runs, each in some process, and yields their reports as they come.

    Args:
        render_run: a function of a module.
        runs: what it is called with.
        jobs: processes; -1 is one a core, 1 is this one.
        backend: joblib's: loky (processes here), ray or dask (a cluster that is running).

    Raises:
        DatasetError: the backend is not installed; or what `render_run` raises.
    """
    if not runs:
        return
    if jobs == 1:
        yield from map(render_run, runs)
        return
    from joblib import Parallel, delayed, parallel_config

    _register(backend)
    with parallel_config(backend=backend):
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        yield from parallel(delayed(render_run)(run) for run in runs)


def claim_folder(folder: Path, recipe: Mapping[str, Any]) -> None:
    """Makes a folder for one rendering, or sees to it that it holds that one.

    Args:
        folder: of the rendering.
        recipe: what tells renderings apart; kept in `rendering.json`.

    Raises:
        DatasetError: another rendering lies there, or the folder cannot be written.
    """
    path = folder / RENDERING_NAME
    if not path.is_file():
        make_folder(folder)
        write_text(path, json.dumps(recipe) + "\n")
        return
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise DatasetError(path, f"is not valid JSON: {error}") from error
    if found != recipe:
        changed = ", ".join(key for key in {**found, **recipe} if found.get(key) != recipe.get(key))
        problem = f"another rendering lies here ({changed}): choose another folder"
        raise DatasetError(path, problem)


def asset_digest(asset: Asset) -> str:
    """Changes with the asset's parts, states and steps."""
    sha = hashlib.sha256(f"{asset.states}{asset.steps}".encode())
    for part in asset.parts:
        sha.update(f"{part.name}{part.color_rgb}{part.mesh.digest}".encode())
    return sha.hexdigest()[:16]


def _register(backend: str) -> None:
    try:
        if backend == "ray":
            from ray.util.joblib import register_ray

            register_ray()
        elif backend == "dask":
            import distributed

            distributed.Client()
    except ImportError as error:
        package = "dask[distributed]" if backend == "dask" else backend
        problem = f"the backend {backend} is not installed: pip install '{package}', or use loky"
        raise DatasetError(Path(backend), problem) from error
