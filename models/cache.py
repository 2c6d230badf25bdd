"""Where snapfit keeps what it can make again: viewpoint models, rendered demo sequences."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs

CACHE_VARIABLE = "SNAPFIT_CACHE"


def cache_directory() -> Path:
    """The folder for files that can be deleted at any time: `$SNAPFIT_CACHE` or the user's cache.

    Made if it is not there yet.

    Raises:
        OSError: the folder cannot be made; set `$SNAPFIT_CACHE` to a writable one.
    """
    named = os.environ.get(CACHE_VARIABLE)
    directory = Path(named).expanduser() if named else Path(platformdirs.user_cache_dir("snapfit"))
    directory.mkdir(parents=True, exist_ok=True)
    return directory
