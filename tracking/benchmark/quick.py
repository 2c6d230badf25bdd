"""A small dataset for a quick benchmark, rendered once and kept in the cache."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

from snapfit.models.asset import BUNDLED
from snapfit.models.cache import cache_directory
from snapfit.models.workbench import dataset
from snapfit.models.workbench.split import Condition

QUICK_FRAMES = 100
"""So many frames of each sequence, from the first, make a quick benchmark."""

ASSET = "hobby-corner-clamp"
CONDITIONS = (Condition.NORMAL, Condition.HAND)

Progress = Callable[[str, float], None]


def quick_dataset(progress: Progress | None = None) -> Path:
    """The folder of the small dataset: the first frames of one asset under two conditions.

    Args:
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        DatasetError: it cannot be written.
    """
    folder = cache_directory() / "quick" / f"{_digest()}-{QUICK_FRAMES}"

    def show(done: int, wanted: int) -> None:
        if progress is not None:
            progress("rendering a small dataset", done / wanted)

    order = dataset.Order(folder, (ASSET,), CONDITIONS, limit=QUICK_FRAMES)
    dataset.render_dataset(order, progress=show)
    return folder


def _digest() -> str:
    """Of the asset, and of the code that draws it."""
    sha = hashlib.sha256()
    for folder in (Path(dataset.__file__).parent, BUNDLED / ASSET):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                sha.update(path.name.encode() + path.read_bytes())
    return sha.hexdigest()[:16]
