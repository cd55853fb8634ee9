"""The integrity paper's walking model in plain numpy, and a UKF step of it from the compiled parts."""

from __future__ import annotations

import numpy as np

from app.estimation import unscented_kalman as ukf
from app.estimation.arrays import FloatArray

STATE_ANGLES = np.array([False, False, True])
OBSERVED_ANGLES = np.array([False, False, False, True, True])


def moved(state: FloatArray, length_m: float, turn_rad: float) -> FloatArray:
    """Eq. 26 in this project's frame: (x, y, heading) after a step."""
    x, y, heading = state
    return np.array([x + length_m * np.sin(heading), y + length_m * np.cos(heading), heading + turn_rad])


def observed(state: FloatArray, before: FloatArray) -> FloatArray:
    """Eq. 27: position, step length, heading change and heading, the change from a known state before."""
    x, y, heading = state
    return np.array([x, y, np.hypot(x - before[0], y - before[1]), heading - before[2], heading])


def ukf_step(
    mean: FloatArray,
    covariance: FloatArray,
    control: tuple[float, float],
    measured: FloatArray,
    q: FloatArray,
    r: FloatArray,
    alpha: float,
) -> tuple[FloatArray, FloatArray]:
    """Prediction and correction with all five observations."""
    wm, wc, spread = ukf.scaled_weights(3, alpha, 2.0, 0.0)
    points = np.array([moved(point, *control) for point in ukf.sigma_points(mean, covariance, spread)])
    prior, prior_covariance = ukf.moments(points, wm, wc, q, STATE_ANGLES)
    points = ukf.sigma_points(prior, prior_covariance, spread)
    seen = np.array([observed(point, mean) for point in points])
    expected, expected_covariance = ukf.moments(seen, wm, wc, r, OBSERVED_ANGLES)
    cross = ukf.cross_covariance(points, prior, STATE_ANGLES, seen, expected, OBSERVED_ANGLES, wc)
    innovation = measured - expected
    innovation[3:] = (innovation[3:] + np.pi) % (2.0 * np.pi) - np.pi
    gain = ukf.gain_of(cross, expected_covariance)
    return ukf.correct(prior, prior_covariance, innovation, expected_covariance, cross, gain, STATE_ANGLES)
