"""Weights that let go of what does not fit."""

from __future__ import annotations

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray

K0, K1 = 2.5, 3.5
REJECTED = 1e-30


@njit(cache=True)
def igg3(standardised: FloatArray, k0: float = K0, k1: float = K1) -> FloatArray:
    """IGG III equivalent weights, integrity paper Eq. 40.

    Parameters
    ----------
    standardised : (m,) residuals in units of their standard deviations.
    k0, k1 : full weight up to k0, none beyond k1; 2.5 and 3.5 in the paper.

    Returns
    -------
    (m,) 1 up to k0, then k0/|s| ((k1 - |s|)/(k1 - k0))^2, beyond k1 (or not finite) 1e-30.
    """
    weights = np.empty(len(standardised))
    for i in range(len(standardised)):
        size = abs(standardised[i])
        if size <= k0:
            weights[i] = 1.0
        elif size < k1:
            weights[i] = max(k0 / size * ((k1 - size) / (k1 - k0)) ** 2, REJECTED)
        else:
            weights[i] = REJECTED
    return weights


@njit(cache=True)
def inflated(noise: FloatArray, weights: FloatArray) -> FloatArray:
    """Measurement noise (m, m) of observations with these weights (m,): R_ij / sqrt(w_i w_j).

    Differs from the paper: Eq. 39's product of the inverse weights with R is not symmetric where R has covariances;
    this one is, and agrees with it on the diagonal.
    """
    root = np.sqrt(weights)
    after = np.empty_like(noise)
    for i in range(len(weights)):
        for j in range(len(weights)):
            after[i, j] = noise[i, j] / (root[i] * root[j])
    return after
