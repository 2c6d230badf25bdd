"""How many threads the tracker's kernels use: a core is left to others while there is time."""

from __future__ import annotations

import logging
import os
from collections import deque
from statistics import median

import numba

_FEW_CORES = 4
_FRAMES = 30
_TOO_LONG, _SHORT = 0.6, 0.4
_log = logging.getLogger(__name__)


class KernelThreads:
    """Chooses the number of threads for the thread that it is made in, from what frames take.

    On few cores kernels on all of them leave no room while a frame is tracked: whoever wants to
    answer meanwhile waits. So one core stays free, unless a frame takes too long then. Where there
    are more cores, and where `NUMBA_NUM_THREADS` says how many threads are wished for, it changes
    nothing.

    Args:
        period_ms: from one frame to the next.
    """

    def __init__(self, period_ms: float) -> None:
        self._all = numba.config.NUMBA_NUM_THREADS
        is_chosen = "NUMBA_NUM_THREADS" in os.environ
        self._few = self._all if is_chosen or self._all > _FEW_CORES else max(self._all - 1, 1)
        self._period_ms = period_ms
        self._lately_ms: deque[float] = deque(maxlen=_FRAMES)
        self.count = self._all
        self._use(self._few)

    def tracked(self, duration_ms: float) -> None:
        """Take note of what a frame took."""
        if self._few == self._all:
            return
        self._lately_ms.append(duration_ms)
        if len(self._lately_ms) < _FRAMES:
            return
        share = median(self._lately_ms) / self._period_ms
        if self.count == self._few:
            if share > _TOO_LONG:
                self._use(self._all)
        elif share * self._all / self._few < _SHORT:  # at worst it takes as much longer
            self._use(self._few)

    def _use(self, count: int) -> None:
        if count != self.count:
            _log.info("the tracker's kernels use %d of %d threads", count, self._all)
            self.count = count
            numba.set_num_threads(count)
        self._lately_ms.clear()
