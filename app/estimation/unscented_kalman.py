"""The unscented transform and Kalman update, as compiled parts that a method's own model is put between.

Integrity paper Eq. 21-25 (Julier's transform with van der Merwe's scaling). A step of a filter is: `sigma_points`, the
motion model on each row, `moments` with the process noise; `sigma_points` again, the measurement model on each row,
`moments` with the measurement noise, `cross_covariance`, `correct`.

Differs from the paper: the points are drawn anew after the prediction, so that they carry the process noise into the
measurement (Eq. 24 uses the old ones, which leave it out). Components that are angles are averaged and subtracted
along the shorter arc.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import BoolArray, FloatArray

PIVOT_SHARE = 1e-14
"""A pivot below this share of its diagonal element is rounding: the matrix is singular in that direction."""


@njit(cache=True)
def scaled_weights(size: int, alpha: float, beta: float, kappa: float) -> tuple[FloatArray, FloatArray, float]:
    """Weights of the scaled sigma points, Eq. 22-23.

    Parameters
    ----------
    size : n, dimension of the state.  alpha : in [1e-4, 1], how far the points lie out.  beta : 2 for a Gaussian.
    kappa : 0 usually; n + kappa > 0.

    Returns
    -------
    (2n + 1,) weights of the mean, (2n + 1,) of the covariance, and n + lambda.
    """
    spread = alpha * alpha * (size + kappa)
    mean = np.full(2 * size + 1, 0.5 / spread)
    mean[0] = (spread - size) / spread
    covariance = mean.copy()
    covariance[0] += 1.0 - alpha * alpha + beta
    return mean, covariance, spread


@njit(cache=True)
def lower_root(covariance: FloatArray) -> FloatArray:
    """(n, n) lower triangular L with L L' = covariance (n, n); of a singular one the columns without variance are 0."""
    size = covariance.shape[0]
    root = np.zeros((size, size))
    for j in range(size):
        pivot = covariance[j, j]
        for k in range(j):
            pivot -= root[j, k] * root[j, k]
        if pivot <= PIVOT_SHARE * abs(covariance[j, j]):
            continue
        root[j, j] = math.sqrt(pivot)
        for i in range(j + 1, size):
            value = covariance[i, j]
            for k in range(j):
                value -= root[i, k] * root[j, k]
            root[i, j] = value / root[j, j]
    return root


@njit(cache=True)
def sigma_points(mean: FloatArray, covariance: FloatArray, spread: float) -> FloatArray:
    """(2n + 1, n) points: the mean, then it plus and minus each column of the root of spread * covariance, Eq. 21."""
    size = len(mean)
    root = lower_root(covariance)
    scale = math.sqrt(spread)
    points = np.empty((2 * size + 1, size))
    points[0] = mean
    for j in range(size):
        for i in range(size):
            points[1 + j, i] = mean[i] + scale * root[i, j]
            points[1 + size + j, i] = mean[i] - scale * root[i, j]
    return points


@njit(cache=True)
def moments(
    points: FloatArray,
    mean_weight: FloatArray,
    covariance_weight: FloatArray,
    noise: FloatArray,
    is_angle: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """Mean (m,) and covariance (m, m) of transformed points, Eq. 24-25.

    Parameters
    ----------
    points : (2n + 1, m).  mean_weight, covariance_weight : (2n + 1,).
    noise : (m, m) covariance of the additive noise.
    is_angle : (m,) components that live on the circle; their mean lies in (-pi, pi].
    """
    count, size = points.shape
    mean = points[0].copy()
    for j in range(size):
        shift = 0.0
        for i in range(1, count):
            away = points[i, j] - points[0, j]
            shift += mean_weight[i] * (wrap(away) if is_angle[j] else away)
        mean[j] += shift
        if is_angle[j]:
            mean[j] = wrap(mean[j])
    covariance = noise.copy()
    away_all = np.empty(size)
    for i in range(count):
        for j in range(size):
            away = points[i, j] - mean[j]
            away_all[j] = wrap(away) if is_angle[j] else away
        for j in range(size):
            for k in range(j + 1):
                covariance[j, k] += covariance_weight[i] * away_all[j] * away_all[k]
    for j in range(size):
        for k in range(j):
            covariance[k, j] = covariance[j, k]
    return mean, covariance


@njit(cache=True)
def cross_covariance(
    states: FloatArray,
    state_mean: FloatArray,
    state_is_angle: BoolArray,
    observed: FloatArray,
    observed_mean: FloatArray,
    observed_is_angle: BoolArray,
    covariance_weight: FloatArray,
) -> FloatArray:
    """(n, m) covariance between (2n + 1, n) state points and (2n + 1, m) what would be observed at each, Eq. 25."""
    count, size = states.shape
    width = observed.shape[1]
    cross = np.zeros((size, width))
    away_all = np.empty(width)
    for i in range(count):
        for k in range(width):
            away = observed[i, k] - observed_mean[k]
            away_all[k] = covariance_weight[i] * (wrap(away) if observed_is_angle[k] else away)
        for j in range(size):
            away = states[i, j] - state_mean[j]
            if state_is_angle[j]:
                away = wrap(away)
            for k in range(width):
                cross[j, k] += away * away_all[k]
    return cross


@njit(cache=True)
def solve_positive(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """X (m, k) of matrix (m, m) X = right (m, k); the matrix positive definite, its elements of any sizes."""
    size, width = right.shape
    root = lower_root(matrix)
    answer = right.copy()
    for k in range(width):
        for i in range(size):
            for j in range(i):
                answer[i, k] -= root[i, j] * answer[j, k]
            answer[i, k] = answer[i, k] / root[i, i] if root[i, i] > 0.0 else 0.0
        for i in range(size - 1, -1, -1):
            for j in range(i + 1, size):
                answer[i, k] -= root[j, i] * answer[j, k]
            answer[i, k] = answer[i, k] / root[i, i] if root[i, i] > 0.0 else 0.0
    return answer


@njit(cache=True)
def gain_of(cross: FloatArray, innovation_covariance: FloatArray) -> FloatArray:
    """(n, m) optimal gain, cross (n, m) times the inverse of the innovation's covariance (m, m), Eq. 25."""
    return np.ascontiguousarray(solve_positive(innovation_covariance, np.ascontiguousarray(cross.T)).T)


@njit(cache=True)
def correct(
    mean: FloatArray,
    covariance: FloatArray,
    innovation: FloatArray,
    innovation_covariance: FloatArray,
    cross: FloatArray,
    gain: FloatArray,
    is_angle: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after a measurement, for any gain.

    Parameters
    ----------
    mean, covariance : (n,), (n, n) before.  innovation, innovation_covariance : (m,), (m, m).
    cross : (n, m) state to measurement.  gain : (n, m), optimal or not.  is_angle : (n,).

    Notes
    -----
    P - K Pxz' - Pxz K' + K Pzz K'; with the optimal gain this is Eq. 25's P - K Pzz K'.
    """
    size, width = gain.shape
    after = mean.copy()
    for i in range(size):
        for k in range(width):
            after[i] += gain[i, k] * innovation[k]
        if is_angle[i]:
            after[i] = wrap(after[i])
    spread = np.empty_like(covariance)
    for i in range(size):
        for j in range(i + 1):
            value = covariance[i, j]
            for k in range(width):
                value -= gain[i, k] * cross[j, k] + cross[i, k] * gain[j, k]
                inner = 0.0
                for m in range(width):
                    inner += innovation_covariance[k, m] * gain[j, m]
                value += gain[i, k] * inner
            spread[i, j] = value
            spread[j, i] = value
    return after, spread
