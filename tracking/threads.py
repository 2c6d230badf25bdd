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
from collections.abc import Callable
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


def started_pair(run: Callable[[bool], None], name: str) -> tuple[threading.Thread, ...]:
    """Two threads beside the tracker, of which one leaves the cores to it and one is urgent.

    A thread cannot always get back a priority that it gave up, so what is urgent now and then
    needs a second one. Parallel kernels of both run on one core.

    Args:
        run: called in each, with whether it is the urgent one.
        name: of the threads.
    """

    def behind() -> None:
        stay_behind()
        run(False)

    def urgent() -> None:
        numba.set_num_threads(1)
        run(True)

    threads = (
        threading.Thread(target=behind, name=name, daemon=True),
        threading.Thread(target=urgent, name=f"{name}-urgent", daemon=True),
    )
    for thread in threads:
        thread.start()
    return threads


def stay_behind() -> None:
    """Have the calling thread, and it alone, leave the cores to the tracker.

    For what goes on beside it and is in no hurry: its parallel kernels run on one core, and on
    Linux, where a thread has a priority of its own, it runs there when nobody else wants to.
    """
    numba.set_num_threads(1)
    if sys.platform == "linux":
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _LEAST_URGENT)
