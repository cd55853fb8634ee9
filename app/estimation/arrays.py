"""Array types used throughout, whose docstrings state the shape, and the search in arrays that are in order."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def looked_up(value: IntArray, ascending: IntArray) -> tuple[IntArray, BoolArray]:
    """(n,) where each value is among others, which are in order, and (n,) whether it is there: nowhere if not."""
    if not len(ascending):
        return np.zeros(len(value), np.int64), np.zeros(len(value), np.bool_)
    at = np.minimum(np.searchsorted(ascending, value), len(ascending) - 1)
    return at, np.asarray(ascending[at] == value, np.bool_)


def within(value: IntArray, ascending: IntArray) -> BoolArray:
    """(n,) whether each value is among others, which are in order."""
    return looked_up(value, ascending)[1]


@njit(cache=True, nogil=True)
def position_of(value: int, ascending: IntArray) -> int:
    """Where one value is among others (n,), which are in order; -1 if nowhere."""
    at = int(np.searchsorted(ascending, value))
    return at if at < len(ascending) and ascending[at] == value else -1
