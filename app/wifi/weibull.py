"""Weibull distribution of the RSSI of an access point at a reference point, from its mean and standard deviation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma

from app.estimation.arrays import Float32Array, FloatArray

_Floats = NDArray[np.floating]

SHAPE_RANGE = (1.5, 2.5)
"""k is clipped to this: integrity_monitoring_ukf, section on the Weibull model."""
SCALE_RANGE_DB = (2.0, 3.5)
"""The standard deviation is clipped to this before it becomes the scale, same place."""
HALF_WINDOW_DB = 5.0
"""A reading r counts as anything in r - 5 to r + 5 dB, same paper, Eq. 13."""


@dataclass(frozen=True, slots=True, eq=False)
class Weibull:
    """k : (n,) shape.  lambda_db : (n,) scale.  theta_dbm : (n,) where the distribution begins."""

    k: Float32Array
    lambda_db: Float32Array
    theta_dbm: Float32Array


def weibull_of(mean_dbm: _Floats, std_db: _Floats) -> Weibull:
    """Parameters by moments: k = STD / ln 2, lambda = s (k + 0.15), theta = O - lambda Gamma(1 + 1/k).

    Parameters
    ----------
    mean_dbm, std_db : (n,).

    Notes
    -----
    k is the clipped one in all three; s is the standard deviation clipped to SCALE_RANGE_DB.
    """
    std = np.asarray(std_db, np.float64)
    k = np.clip(std / math.log(2.0), *SHAPE_RANGE)
    scale = np.clip(std, *SCALE_RANGE_DB) * (k + 0.15)
    theta = mean_dbm - scale * gamma(1.0 + 1.0 / k)
    return Weibull(k.astype(np.float32), scale.astype(np.float32), theta.astype(np.float32))


def window_likelihood(rssi_dbm: _Floats, k: _Floats, lambda_db: _Floats, theta_dbm: _Floats) -> FloatArray:
    """Probability of a reading within HALF_WINDOW_DB: F(r + 5) - F(r - 5). Arguments broadcast."""
    above = _cdf(rssi_dbm + HALF_WINDOW_DB, k, lambda_db, theta_dbm)
    return above - _cdf(rssi_dbm - HALF_WINDOW_DB, k, lambda_db, theta_dbm)


def _cdf(x_dbm: _Floats, k: _Floats, lambda_db: _Floats, theta_dbm: _Floats) -> FloatArray:
    probability: FloatArray = -np.expm1(-np.power(np.maximum(x_dbm - theta_dbm, 0.0) / lambda_db, k))
    return probability
