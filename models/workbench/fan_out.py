"""Work spread over cores or a cluster by joblib, and folders that hold one rendering each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from snapfit.models.asset import Asset
from snapfit.models.bop_writer import make_folder, write_text
from snapfit.models.errors import DatasetError

RENDERING_NAME = "rendering.json"
_RUNS_AT_ONCE = 4
_PACKAGES = ("ray", "dask", "distributed")

Run = TypeVar("Run")
Report = TypeVar("Report")


def fan_out(
    render_run: Callable[[Run], Report], runs: Sequence[Run], jobs: int, backend: str
) -> Iterator[Report]:
    """Renders runs, each in some process, and yields their reports as they come.

    Args:
        render_run: a function of a module.
        runs: what it is called with.
        jobs: processes; -1 is one a core, of the cluster if there is one; 1 by loky is this one.
        backend: joblib's: loky (processes here), ray or dask (a cluster that is running).

    Raises:
        DatasetError: the backend is not installed, or its cluster not to be had; or what
            `render_run` raises.
    """
    if not runs:
        return
    if jobs == 1 and backend == "loky":
        yield from map(render_run, runs)
        return
    from joblib import Parallel, delayed, effective_n_jobs, parallel_config

    with _connected(backend, jobs), parallel_config(backend=backend):
        # Ray's backend gives results by the list: some runs for each process, then the next ones.
        streams = backend != "ray"
        size = len(runs) if streams else _RUNS_AT_ONCE * effective_n_jobs(jobs)
        result = "generator_unordered" if streams else "list"
        with Parallel(n_jobs=jobs, return_as=result, batch_size=1) as parallel:
            for i in range(0, len(runs), size):
                yield from parallel(delayed(render_run)(run) for run in runs[i : i + size])


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


@contextmanager
def _connected(backend: str, jobs: int) -> Iterator[None]:
    """A cluster that is running, or else a small one on this machine while it is needed."""
    try:
        if backend == "ray":
            with _ray():
                yield
        elif backend == "dask":
            with _dask(jobs):
                yield
        else:
            yield
    except ModuleNotFoundError as error:
        if error.name not in _PACKAGES:
            raise
        problem = f"the backend {backend} is not installed: pip install 'snapfit[{backend}]'"
        raise DatasetError(Path(backend), f"{problem}, or use loky") from error


@contextmanager
def _ray() -> Iterator[None]:
    """Ray's own variable `RAY_ADDRESS` names the cluster."""
    import ray
    from ray.util.joblib import register_ray

    register_ray()
    if ray.is_initialized():
        yield
        return
    try:
        ray.init()
    except (ConnectionError, RuntimeError) as error:
        raise DatasetError(Path("ray"), f"no connection to the cluster: {error}") from error
    try:
        yield
    finally:
        ray.shutdown()


@contextmanager
def _dask(jobs: int) -> Iterator[None]:
    """Dask's own variable `DASK_SCHEDULER_ADDRESS` names the cluster."""
    import dask
    import distributed

    address = dask.config.get("scheduler-address", None)
    try:
        client = (
            distributed.Client(address)
            if address
            else distributed.Client(
                threads_per_worker=1, n_workers=max(jobs, 0) or None, dashboard_address=None
            )
        )
    except OSError as error:
        problem = f"no connection to the cluster at {address}: {error}"
        raise DatasetError(Path("dask"), problem) from error
    with client:
        if max(client.nthreads().values(), default=1) > 1:
            raise DatasetError(
                Path("dask"),
                "a worker renders one thing at a time: start workers with --nthreads 1 "
                "and one for each core (--nworkers auto)",
            )
        yield
