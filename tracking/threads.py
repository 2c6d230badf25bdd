"""Numba's threading layer: one that two Python threads may enter at once.

Numba's own `workqueue` layer crashes when two threads run parallel kernels. Intel's TBB does not;
its PyPI wheel puts the library where the loader does not look, so it is loaded by hand first.
"""

from __future__ import annotations

import ctypes
import logging
import sys
import threading
from pathlib import Path

import numba

_log = logging.getLogger(__name__)
_TBB = {"linux": "lib/libtbb.so.12", "win32": "Library/bin/tbb12.dll"}

parallel_kernels = threading.RLock()
"""Held around parallel kernels: costs nothing, and keeps `workqueue` safe where it is all there is.
"""


def prepare_threading_layer() -> None:
    """Load TBB from the environment that Python runs in, and prefer it to the other layers."""
    numba.config.THREADING_LAYER_PRIORITY = ["tbb", "omp", "workqueue"]
    library = Path(sys.prefix) / _TBB.get(sys.platform, "lib/libtbb.12.dylib")
    if not library.is_file():
        _log.info("no TBB at %s: Numba chooses its threading layer by itself", library)
        return
    try:
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    except OSError as error:
        _log.warning("TBB at %s does not load (%s): parallel kernels may be slower", library, error)


def keep_to_one_core() -> None:
    """Have the parallel kernels of the calling thread, and of it alone, run on one core.

    For what goes on beside the tracker: it is in no hurry, and the tracker needs the others.
    """
    numba.set_num_threads(1)
