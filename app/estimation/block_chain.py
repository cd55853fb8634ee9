"""Least squares over a chain of states, each tied to its neighbours: solved in time linear in the chain's length.

The normal equations of such a problem are block tridiagonal. Banded Cholesky factors solve them, and the parts of the
inverse that lie within the band, which hold every state's covariance, follow from the factors alone (Takahashi,
Fagan and Chin 1973).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.linalg import cho_solve_banded, cholesky_banded

from app.estimation.arrays import FloatArray


def banded(diagonal: FloatArray, below: FloatArray) -> FloatArray:
    """Lower banded form (2 m, n m) of a symmetric block tridiagonal matrix, as scipy.linalg has it.

    Parameters
    ----------
    diagonal : (n, m, m) blocks on the diagonal.  below : (n - 1, m, m) blocks under it.
    """
    count, size = diagonal.shape[:2]
    band = np.zeros((2 * size, count * size))
    for row in range(size):
        for column in range(size):
            if row >= column:
                band[row - column, column::size] = diagonal[:, row, column]
            band[size + row - column, column : (count - 1) * size : size] = below[:, row, column]
    return band


def solved(band: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The solution x of A x = right, (n m,), and the lower factor of A, both from A's banded form.

    Raises
    ------
    numpy.linalg.LinAlgError : A is not positive definite.
    """
    factor = cholesky_banded(band, lower=True, check_finite=False)
    return np.asarray(cho_solve_banded((factor, True), right, check_finite=False)), factor


def covariances(factor: FloatArray, size: int) -> tuple[FloatArray, FloatArray]:
    """Blocks of the inverse: (n, m, m) on the diagonal, and (n - 1, m, m) of each state with the one before it.

    Parameters
    ----------
    factor : (2 m, n m) from solved().  size : m.
    """
    band = _inverse_within(np.ascontiguousarray(factor.T))
    count = len(band) // size
    diagonal, below = np.empty((count, size, size)), np.empty((count - 1, size, size))
    for row in range(size):
        for column in range(size):
            high, low = max(row, column), min(row, column)
            diagonal[:, row, column] = band[low::size, high - low]
            below[:, row, column] = band[column : (count - 1) * size : size, size + row - column]
    return diagonal, below


@njit(cache=True)
def _inverse_within(factor: FloatArray) -> FloatArray:
    """(n, w) inverse of L L' within L's band: [j, d] is the element of row j + d and column j, for both arrays."""
    count, width = factor.shape
    inverse = np.zeros((count, width))
    for column in range(count - 1, -1, -1):
        reach = min(width, count - column)
        pivot = factor[column, 0]
        for offset in range(reach - 1, -1, -1):
            total = 1.0 / pivot if offset == 0 else 0.0
            for k in range(1, reach):
                low, high = min(k, offset), max(k, offset)
                total -= factor[column, k] * inverse[column + low, high - low]
            inverse[column, offset] = total / pivot
    return inverse
