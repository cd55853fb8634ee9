"""The extended Kalman filter: prediction and correction on arrays, the model linearised by the caller."""

from __future__ import annotations

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray
from app.estimation.unscented_kalman import gain_of


@njit(cache=True)
def predict_covariance(covariance: FloatArray, transition: FloatArray, noise: FloatArray) -> FloatArray:
    """F P F' + Q.

    Parameters
    ----------
    covariance, noise : (n, n).  transition : (n, n) Jacobian of the motion at the mean.
    """
    after = transition @ covariance @ transition.T + noise
    return 0.5 * (after + after.T)


@njit(cache=True)
def innovation_covariance(covariance: FloatArray, jacobian: FloatArray, noise: FloatArray) -> FloatArray:
    """(m, m) H P H' + R, of covariance (n, n), jacobian (m, n) and noise (m, m)."""
    after = jacobian @ covariance @ jacobian.T + noise
    return 0.5 * (after + after.T)


@njit(cache=True)
def correct(
    mean: FloatArray, covariance: FloatArray, innovation: FloatArray, jacobian: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """State (n,) and covariance (n, n) after a measurement.

    Parameters
    ----------
    innovation : (m,) measured minus predicted, angles already wrapped.  jacobian : (m, n) of the measurement at the
        mean.  noise : (m, m), may be inflated or singular as long as H P H' + R is positive definite.

    Notes
    -----
    Joseph's form, which stays positive semidefinite whatever the rounding. Angles of the state are not wrapped here.
    """
    cross = covariance @ jacobian.T
    gain = gain_of(np.ascontiguousarray(cross), innovation_covariance(covariance, jacobian, noise))
    keep = np.eye(len(mean)) - gain @ jacobian
    after = keep @ covariance @ keep.T + gain @ noise @ gain.T
    return mean + gain @ innovation, 0.5 * (after + after.T)
