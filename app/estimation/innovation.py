"""Tests of an innovation against its covariance."""

from __future__ import annotations

from functools import lru_cache

from numba import njit
from scipy.special import chdtri

from app.estimation.arrays import FloatArray
from app.estimation.unscented_kalman import solve_positive


@lru_cache(256)
def chi2_threshold(size: int, false_alarm: float) -> float:
    """What a chi-squared variable of `size` degrees of freedom exceeds with that probability, Eq. 37."""
    return float(chdtri(size, false_alarm))


@lru_cache(256)
def f_threshold(size: int, false_alarm: float) -> float:
    """Upper quantile of F(size, infinity): of the squared Mahalanobis distance divided by `size`."""
    return chi2_threshold(size, false_alarm) / size


@njit(cache=True)
def normalised_square(innovation: FloatArray, covariance: FloatArray) -> float:
    """r' D^-1 r, Eq. 34, of innovation (m,) and its positive definite covariance (m, m)."""
    solved = solve_positive(covariance, innovation.reshape(-1, 1))
    total = 0.0
    for i in range(len(innovation)):
        total += innovation[i] * solved[i, 0]
    return total
