"""Open3D, imported only where it is used: it takes long and needs libraries of the system."""

from __future__ import annotations

import importlib
from typing import Any

from snapfit.tracking.errors import TrackingError
from snapfit.tracking.threads import prepare_threading_layer


def open3d() -> Any:
    """The module.

    Raises:
        TrackingError: it is not installed, or a library of the system is missing.
    """
    # Open3D brings a TBB that is too old for Numba: the one that is loaded first serves both.
    prepare_threading_layer()
    try:
        return importlib.import_module("open3d")
    except (ImportError, OSError) as error:
        raise TrackingError(
            f"the geometric detector needs Open3D, which cannot be imported: {error}. Install it "
            "with `pip install open3d-cpu` (Linux on x86-64) or `pip install open3d`; on Linux it "
            "needs libraries of the system too: `apt-get install libgl1 libegl1 libx11-6 libgomp1 "
            "libusb-1.0-0`"
        ) from error
