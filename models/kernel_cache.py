"""Where Numba keeps the compiled kernels: one folder for each version of their sources.

Numba compiles a kernel anew when its own file changes, but not when a kernel that it calls has
changed in another file: the old code would go on running inside the new. So the folder's name
holds a digest of all files with kernels; folders that nobody has used for a week are removed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import sys
import time
from pathlib import Path

from snapfit.models.cache import cache_directory

_ROOMS = ("models", "tracking")
_UNUSED_S = 7 * 86400.0


def prepare_kernel_cache() -> None:
    """Tell Numba its folder, unless `NUMBA_CACHE_DIR` is set; to be called before its import."""
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    try:
        folder = cache_directory() / "kernels" / _digest()
        folder.mkdir(parents=True, exist_ok=True)
        folder.touch()
    except OSError:
        return  # Numba then looks for a place by itself.
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    _forget_old(folder.parent)


def _digest() -> str:
    sha = hashlib.sha256()
    house = Path(__file__).resolve().parent.parent
    for room in _ROOMS:
        for path in sorted((house / room).rglob("*.py")):
            source = path.read_bytes()
            if b"njit" in source or "kernels" in path.parent.name:
                sha.update(str(path.relative_to(house)).encode() + source)
    return sha.hexdigest()[:16]


def _forget_old(folder: Path) -> None:
    with contextlib.suppress(OSError):  # another process may be tidying up too
        # Another process may be using a folder right now: only what is long unused may go.
        for path in folder.iterdir():
            if path.stat().st_mtime < time.time() - _UNUSED_S:
                shutil.rmtree(path, ignore_errors=True)
