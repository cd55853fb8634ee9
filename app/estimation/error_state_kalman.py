"""The error-state Kalman filter: it estimates what is wrong with a nominal solution, which is then put right.

The nominal state is moved by its own nonlinear equations; the filter holds only the covariance of its error, whose
mean is zero again after every feedback. Errors are added to the nominal state, so feedback leaves the covariance as is.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray
from app.estimation.extended_kalman import correct


@njit(cache=True)
def error_after(
    covariance: FloatArray, innovation: FloatArray, jacobian: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Estimated error (n,) of the nominal state and its covariance (n, n) after a measurement.

    Parameters
    ----------
    covariance : (n, n) of the error before.  innovation : (m,) measured minus what the nominal state predicts.
    jacobian : (m, n) of the measurement to the error.  noise : (m, m).
    """
    return correct(np.zeros(covariance.shape[0]), covariance, innovation, jacobian, noise)
