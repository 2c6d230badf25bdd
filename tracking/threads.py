"""Numba's threading layer: one that two Python threads may enter at once.

Numba's own `workqueue` layer crashes when two threads run parallel kernels. Intel's TBB does not;
its PyPI wheel puts the library where the loader does not look, so it is loaded by hand first.
"""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import threading
from contextlib import suppress
from pathlib import Path

import numba

_log = logging.getLogger(__name__)
_LEAST_URGENT = 19
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


def use_one_core() -> None:
    """Have parallel kernels that the calling thread starts run on one core."""
    numba.set_num_threads(1)


def stay_behind() -> None:
    """Have the calling thread, and it alone, leave the cores to the tracker.

    For what goes on beside it and is in no hurry: its parallel kernels run on one core, and on
    Linux, where a thread has a priority of its own, it runs there when nobody else wants to.
    """
    use_one_core()
    if sys.platform == "linux":
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _LEAST_URGENT)
