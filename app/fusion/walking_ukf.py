"""The walking model of the integrity paper as compiled steps of the unscented filter.

State: x, y, heading, as in Eq. 26; or those three and, behind them, what a session has to learn: the logarithm of the
step-length scale, the constant angle between the phone's heading and the walking direction, and the slowly varying
error of WiFi fixes (x, y).

Observations, in the order of Eq. 27: x and y by WiFi, step length, heading change, heading.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.estimation.unscented_kalman import (
    cross_covariance,
    gain_of,
    moments,
    scaled_weights,
    sigma_points,
)

X, Y, HEADING, LOG_SCALE, ASKEW, WIFI_X, WIFI_Y = range(7)
PLAIN, LEARNING = 3, 7
"""Sizes of the state: the paper's, and with what is learnt."""
OF_WIFI_X, OF_WIFI_Y, OF_LENGTH, OF_TURN, OF_HEADING = range(5)
BETA, KAPPA = 2.0, 0.0


@njit(cache=True)
def angles_of_state(size: int) -> BoolArray:
    """(n,) which components of the state are angles. The askew angle is one as well."""
    angles = np.zeros(size, np.bool_)
    angles[HEADING] = True
    if size > PLAIN:
        angles[ASKEW] = True
    return angles


@njit(cache=True)
def predict(
    mean: FloatArray,
    covariance: FloatArray,
    length_m: float,
    turn_rad: float,
    turned_before: float,
    bias_kept: float,
    noise: FloatArray,
    alpha: float,
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after a step.

    Parameters
    ----------
    mean, covariance : (n,), (n, n) with n of 3 or 7.
    length_m, turn_rad : the control: step length before any scale, heading change.
    turned_before : share of the turn that comes before the displacement; 0 in Eq. 26, 0.5 is the middle of the step.
    bias_kept : share of the WiFi error that is still the same after this step.
    noise : (n,) variances of the process noise.
    """
    size = len(mean)
    mean_weight, covariance_weight, spread = scaled_weights(size, alpha, BETA, KAPPA)
    points = sigma_points(mean, covariance, spread)
    for i in range(len(points)):
        point = points[i]
        direction = point[HEADING] + turned_before * turn_rad
        length = length_m * math.exp(point[LOG_SCALE]) if size > PLAIN else length_m
        point[X] += length * math.sin(direction)
        point[Y] += length * math.cos(direction)
        point[HEADING] += turn_rad
        if size > PLAIN:
            point[WIFI_X] *= bias_kept
            point[WIFI_Y] *= bias_kept
    return moments(points, mean_weight, covariance_weight, np.diag(noise), angles_of_state(size))


@njit(cache=True)
def expect(
    mean: FloatArray,
    covariance: FloatArray,
    measured: FloatArray,
    noise: FloatArray,
    which: IntArray,
    before: FloatArray,
    ahead_m: float,
    alpha: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """What of a measurement was not expected.

    Parameters
    ----------
    mean, covariance : (n,), (n, n) the prior.
    measured : (m,) and noise (m, m) of the observations that are present, numbered by which (m,).
    before : (3,) the estimate before the step: from where the step length is measured.
    ahead_m : how far along the heading, before any scale, the place of the WiFi fix lies from the last step's end.

    Returns
    -------
    innovation (m,), its covariance Pzz (m, m), the cross covariance Pxz (n, m), and the optimal gain (n, m).
    """
    size, width = len(mean), len(which)
    mean_weight, covariance_weight, spread = scaled_weights(size, alpha, BETA, KAPPA)
    points = sigma_points(mean, covariance, spread)
    seen = np.empty((len(points), width))
    is_angle = np.zeros(width, np.bool_)
    for k in range(width):
        is_angle[k] = which[k] == OF_TURN or which[k] == OF_HEADING
    for i in range(len(points)):
        point = points[i]
        scale = math.exp(point[LOG_SCALE]) if size > PLAIN else 1.0
        for k in range(width):
            kind = which[k]
            if kind == OF_WIFI_X:
                seen[i, k] = point[X] + ahead_m * scale * math.sin(point[HEADING])
                if size > PLAIN:
                    seen[i, k] += point[WIFI_X]
            elif kind == OF_WIFI_Y:
                seen[i, k] = point[Y] + ahead_m * scale * math.cos(point[HEADING])
                if size > PLAIN:
                    seen[i, k] += point[WIFI_Y]
            elif kind == OF_LENGTH:
                seen[i, k] = math.hypot(point[X] - before[X], point[Y] - before[Y]) / scale
            elif kind == OF_TURN:
                seen[i, k] = point[HEADING] - before[HEADING]
            else:
                seen[i, k] = point[HEADING] + (point[ASKEW] if size > PLAIN else 0.0)
    expected, spread_of = moments(seen, mean_weight, covariance_weight, noise, is_angle)
    state_angles = angles_of_state(size)
    cross = cross_covariance(points, mean, state_angles, seen, expected, is_angle, covariance_weight)
    innovation = measured - expected
    for k in range(width):
        if is_angle[k]:
            innovation[k] = wrap(innovation[k])
    return innovation, spread_of, cross, gain_of(cross, spread_of)
