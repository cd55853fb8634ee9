"""What a cloud of particles expects of a fix, how fixes weigh it, and where it lies, compiled.

Rows of particles are those of app/fusion/cloud_kernels.py.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.arrays import Float32Array, FloatArray
from app.fusion.cloud_kernels import HEADING, LOG_SCALE, WIFI_X, WIFI_Y, X, Y

_ROUNDS, _SOFT_M2 = 5, 0.25
"""Of Weiszfeld's iteration from the mean to the geometric median, and what keeps it from a particle's own place."""


@njit(cache=True, nogil=True)
def expected(
    particles: Float32Array, weight: Float32Array, ahead_m: float, biased: float
) -> tuple[FloatArray, FloatArray]:
    """Mean (2,) and covariance (2, 2) over the cloud of where a fix is expected, without the fix's own noise.

    ahead_m : before any scale, how far the walker is past the last step's end.
    biased : 1 of a fix with WiFi's lasting error, 0 of one without.
    """
    mean, covariance = np.zeros(2), np.zeros((2, 2))
    places = np.empty((len(particles), 2))
    for i in range(len(particles)):
        reach_m = ahead_m * math.exp(particles[i, LOG_SCALE])
        places[i, 0] = particles[i, X] + reach_m * math.sin(particles[i, HEADING]) + biased * particles[i, WIFI_X]
        places[i, 1] = particles[i, Y] + reach_m * math.cos(particles[i, HEADING]) + biased * particles[i, WIFI_Y]
        mean += weight[i] * places[i]
    for i in range(len(particles)):
        apart = places[i] - mean
        for a in range(2):
            for b in range(2):
                covariance[a, b] += weight[i] * apart[a] * apart[b]
    return mean, covariance


@njit(cache=True, nogil=True)
def about_median(
    particles: Float32Array, weight: Float32Array, ahead_m: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Geometric median (2,) of the cloud ahead_m further on, covariance (2, 2) and distances (n,) about it."""
    count = len(particles)
    x_m, y_m = np.empty(count), np.empty(count)
    centre_m, total = np.zeros(2), 0.0
    for i in range(count):
        reach_m = ahead_m * math.exp(particles[i, LOG_SCALE]) if ahead_m > 0.0 else 0.0
        x_m[i] = particles[i, X] + reach_m * math.sin(particles[i, HEADING])
        y_m[i] = particles[i, Y] + reach_m * math.cos(particles[i, HEADING])
        centre_m[0] += weight[i] * x_m[i]
        centre_m[1] += weight[i] * y_m[i]
        total += weight[i]
    centre_m /= total
    for _ in range(_ROUNDS):
        east, north, pulls = 0.0, 0.0, 0.0
        for i in range(count):
            pull = weight[i] / math.sqrt((x_m[i] - centre_m[0]) ** 2 + (y_m[i] - centre_m[1]) ** 2 + _SOFT_M2)
            east += pull * x_m[i]
            north += pull * y_m[i]
            pulls += pull
        centre_m[0], centre_m[1] = east / pulls, north / pulls
    covariance, distance_m = np.zeros((2, 2)), np.empty(count)
    for i in range(count):
        east, north = x_m[i] - centre_m[0], y_m[i] - centre_m[1]
        distance_m[i] = math.sqrt(east * east + north * north)
        covariance[0, 0] += weight[i] * east * east / total
        covariance[1, 1] += weight[i] * north * north / total
        covariance[0, 1] += weight[i] * east * north / total
    covariance[1, 0] = covariance[0, 1]
    return centre_m, covariance, distance_m


@njit(cache=True, nogil=True)
def weighed(
    particles: Float32Array,
    weight: Float32Array,
    xy_m: FloatArray,
    spread_m2: float,
    gain: float,
    ahead_m: float,
    biased: float,
) -> tuple[Float32Array, Float32Array]:
    """Cloud and weights (n,) after a fix. spread_m2 : variance of the fix about where a particle expects it, in each
    direction.  gain : by what share of the difference a particle's WiFi error follows."""
    particles = particles.copy()
    logarithm = np.empty(len(particles))
    for i in range(len(particles)):
        reach_m = ahead_m * math.exp(particles[i, LOG_SCALE])
        east_m = xy_m[0] - particles[i, X] - reach_m * math.sin(particles[i, HEADING])
        north_m = xy_m[1] - particles[i, Y] - reach_m * math.cos(particles[i, HEADING])
        east_m -= biased * particles[i, WIFI_X]
        north_m -= biased * particles[i, WIFI_Y]
        logarithm[i] = -0.5 * (east_m * east_m + north_m * north_m) / spread_m2
        particles[i, WIFI_X] += gain * east_m
        particles[i, WIFI_Y] += gain * north_m
    likely = weight * np.exp(logarithm - logarithm.max())
    return particles, (likely / likely.sum()).astype(np.float32)
