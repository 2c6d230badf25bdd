"""Rows of arrays that lie anywhere in memory, by address.

A list of arrays would do, but Numba compiles its typed list anew in every process: over a second
that a worker which comes back after a crash does not have.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from snapfit.tracking.kernels.types import I16


@intrinsic
def _as_pointer(_context: Any, address: Any) -> tuple[Any, Any]:
    """An integer as a pointer."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


@njit(cache=True, nogil=True)
def view_rows(address: np.int64, view: int, n_rows: int, width: int) -> I16:
    """Rows (n_rows, width) of one view of an array (views, n_rows, width) int16, C order.

    Args:
        address: of the array's first element; whoever gives it keeps the array alive.
        view: index of the view, within the array.
        n_rows, width: shape of a view.
    """
    rows: I16 = carray(_as_pointer(address + 2 * view * n_rows * width), (n_rows, width), np.int16)
    return rows
