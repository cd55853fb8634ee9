from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.estimation.block_chain import banded, covariances, solved


def chained(count: int, size: int, seed: int) -> FloatArray:
    """A positive definite block tridiagonal matrix."""
    rng = np.random.default_rng(seed)
    matrix = 0.1 * np.eye(count * size)
    for k in range(count - 1):
        square = rng.normal(size=(2 * size, 2 * size))
        both = slice(k * size, (k + 2) * size)
        matrix[both, both] += square @ square.T
    return matrix


def blocks(matrix: FloatArray, count: int, size: int) -> tuple[FloatArray, FloatArray]:
    """Those on the diagonal, and those under it."""
    cut = matrix.reshape(count, size, count, size).swapaxes(1, 2)
    return cut[range(count), range(count)], cut[range(1, count), range(count - 1)]


@given(st.integers(1, 7), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_solution_and_covariances_are_those_of_the_whole_matrix(count: int, size: int, seed: int) -> None:
    matrix = chained(count, size, seed)
    right = np.random.default_rng(seed).normal(size=count * size)
    solution, factor = solved(banded(*blocks(matrix, count, size)), right)
    assert np.allclose(matrix @ solution, right, atol=1e-8)
    inverse: FloatArray = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    for found, expected in zip(covariances(factor, size), blocks(inverse, count, size), strict=True):
        assert np.allclose(found, expected, atol=1e-8 * np.abs(inverse).max())


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        solved(banded(np.array([[[-1.0]]]), np.empty((0, 1, 1))), np.ones(1))
