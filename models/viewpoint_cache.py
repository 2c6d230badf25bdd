"""Viewpoint models on disk: made once per mesh, memory-mapped afterwards.

A file is one line of JSON (metadata, the place of each array, a checksum) and then the arrays.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import tempfile
import zlib
from collections.abc import Callable
from functools import cache as run_once
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.cache import cache_directory
from snapfit.models.mesh import Mesh
from snapfit.models.viewpoint_grid import N_DIVISIONS
from snapfit.models.viewpoint_model import ViewpointModel

_log = logging.getLogger(__name__)

_ARRAYS = (
    "directions",
    "neighbours",
    "contour",
    "surface",
    "contour_length_m",
    "surface_area_m2",
)
_ALIGNMENT = 64
_FILES_KEPT = 48
# What decides the content of a model: when one of these changes, all models are made anew.
_SOURCES = (
    "raster_kernels",
    "viewpoint_build",
    "viewpoint_contour",
    "viewpoint_grid",
    "viewpoint_kernels",
    "viewpoint_model",
    "viewpoint_sampling",
)


def load_viewpoint_model(
    mesh: Mesh,
    progress: Callable[[float], None] | None = None,
    cache: Path | None = None,
    *,
    n_divisions: int = N_DIVISIONS,
) -> ViewpointModel:
    """The viewpoint model of a mesh: from the cache, or generated and put there.

    Safe when several processes do so at once. Without a writable cache the model stays in memory.

    Args:
        mesh: the body.
        progress: called with the share that is done, up to 1; once with 1 for a cached model.
        cache: folder of the cache; `cache_directory() / "viewpoints"` if None.
        n_divisions: of the geodesic grid; 4 gives 2562 views.

    Raises:
        ViewpointModelError: the mesh is empty, or no view shows anything of it.
    """
    path = _path_of(mesh, cache, n_divisions)
    model = _read(path) if path is not None else None
    if model is None:
        # Here, because who reads a cached model need not load Numba.
        from snapfit.models.viewpoint_build import build_viewpoint_model

        model = _sealed(build_viewpoint_model(mesh, progress, n_divisions=n_divisions))
        if path is not None and _write(path, model):
            model = _read(path) or model
    elif progress is not None:
        progress(1.0)
    return model


def _path_of(mesh: Mesh, cache: Path | None, n_divisions: int) -> Path | None:
    """Where the mesh's model belongs; None where no cache can be made."""
    try:
        folder = cache_directory() / "viewpoints" if cache is None else cache
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _log.warning("no cache for viewpoint models (%s); set SNAPFIT_CACHE to a folder", error)
        return None
    return folder / f"{mesh.digest[:24]}-{n_divisions}-{_code_digest()[:12]}.viewpoints"


@run_once
def _code_digest() -> str:
    sha = hashlib.sha256()
    for name in _SOURCES:
        sha.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return sha.hexdigest()


def _sealed(model: ViewpointModel) -> ViewpointModel:
    """The same model with read-only arrays, like one from the cache."""
    for name in _ARRAYS:
        getattr(model, name).setflags(write=False)
    return model


def _write(path: Path, model: ViewpointModel) -> bool:
    """Put a model into the cache, whole or not at all; False where that fails."""
    places: dict[str, dict[str, Any]] = {}
    offset, checksum = 0, 0
    for name in _ARRAYS:
        array = getattr(model, name)
        places[name] = {"dtype": array.dtype.str, "shape": array.shape, "offset": offset}
        padded = _padded(array)
        offset += len(padded)
        checksum = zlib.crc32(padded, checksum)
    header = {
        "center_m": model.center_m.tolist(),
        "radius_m": model.radius_m,
        "unit_m": model.unit_m,
        "arrays": places,
        "size": offset,
        "crc32": checksum,
    }
    line = json.dumps(header).encode()
    line += b" " * (-(len(line) + 1) % _ALIGNMENT) + b"\n"
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            temporary = Path(file.name)
            try:
                file.write(line)
                for name in _ARRAYS:
                    file.write(_padded(getattr(model, name)))
                file.close()
                temporary.replace(path)
            finally:
                temporary.unlink(missing_ok=True)
        _forget_oldest(path.parent)
    except OSError as error:
        _log.warning("the viewpoint model could not be cached in %s (%s)", path.parent, error)
        return False
    return True


def _padded(array: npt.NDArray[Any]) -> bytes:
    data = array.tobytes()
    return data + b"\0" * (-len(data) % _ALIGNMENT)


def _read(path: Path) -> ViewpointModel | None:
    """The model in a file; None where there is none or the file is damaged."""
    try:
        with path.open("rb") as file:
            line = file.readline()
        content = np.memmap(path, dtype=np.uint8, mode="r", offset=len(line)).view(np.ndarray)
        model = _parsed(json.loads(line), content)
        with contextlib.suppress(OSError):  # of another user: it is only read
            os.utime(path)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        _log.warning("%s is damaged (%s): the viewpoint model is made anew", path, error)
        return None
    return model


def _parsed(header: dict[str, Any], content: npt.NDArray[np.uint8]) -> ViewpointModel:
    if len(content) != header["size"] or zlib.crc32(content.data) != header["crc32"]:
        raise ValueError("its checksum is wrong")
    arrays = {}
    for name in _ARRAYS:
        place = header["arrays"][name]
        dtype, shape, start = np.dtype(place["dtype"]), place["shape"], place["offset"]
        stop = start + int(np.prod(shape)) * dtype.itemsize
        arrays[name] = content[start:stop].view(dtype).reshape(shape)
    return ViewpointModel(
        center_m=np.array(header["center_m"]),
        radius_m=header["radius_m"],
        unit_m=header["unit_m"],
        **arrays,
    )


def _forget_oldest(folder: Path) -> None:
    """Keep the models that were used last; the others can be made again."""
    used_at: dict[Path, float] = {}
    for file in folder.glob("*.viewpoints"):
        with contextlib.suppress(FileNotFoundError):  # another process has just forgotten it
            used_at[file] = file.stat().st_mtime
    for file in sorted(used_at, key=used_at.__getitem__)[:-_FILES_KEPT]:
        file.unlink(missing_ok=True)
