"""What the gyroscope shows when it should show nothing: its bias, learnt at rest and from what gravity corrects.

The Kalman filter of VQF (Laidig and Seel 2023, doi:10.1016/j.inffus.2022.10.014, section 3.4), with its noise levels.
"""

from __future__ import annotations

import math

from numba import njit

from app.estimation.angles import DEGREE
from app.estimation.arrays import FloatArray

BIAS_START, BIAS_LIMIT = 0.5 * DEGREE, 2.0 * DEGREE
BIAS_DRIFT = (0.1 * DEGREE) ** 2 / 100.0
"""rad^2/s^3: grows to 0.1 degree/s in 100 s."""
BIAS_MOTION, BIAS_REST, BIAS_VERTICAL = (0.1 * DEGREE) ** 2, (0.03 * DEGREE) ** 2, 1e-4
REST_RATE, REST_FORCE_MPS2, REST_AFTER_S, TAU_REST_S = 2.0 * DEGREE, 0.5, 1.5, 0.5


@njit(cache=True)
def notice_rest(sample: FloatArray, row: int, interval_s: float, rest_s: float, rest: FloatArray) -> float:
    """For how long the phone has been at rest: neither rate nor acceleration leaves its own slow mean.

    sample : (n, 3) accelerations, of which one row is taken.  rest_s : the answer before.
    rest : (2, 6) slow mean of rate and acceleration, newest rate; changed in place.
    """
    gain = -math.expm1(-interval_s / TAU_REST_S)
    moved_force, moved_rate = 0.0, 0.0
    for k in range(3):
        rest[0, 3 + k] += gain * (sample[row, k] - rest[0, 3 + k])
        moved_force += (sample[row, k] - rest[0, 3 + k]) ** 2
        moved_rate += (rest[1, k] - rest[0, k]) ** 2
    slow = max(abs(rest[0, 0]), abs(rest[0, 1]), abs(rest[0, 2])) < BIAS_LIMIT
    if moved_force < REST_FORCE_MPS2**2 and moved_rate < REST_RATE**2 and slow:
        return rest_s + interval_s
    return 0.0


@njit(cache=True)
def learn_bias(
    own: FloatArray,
    tilt: tuple[float, float],
    interval_s: float,
    gain: float,
    at_rest: bool,
    bias: FloatArray,
    covariance: FloatArray,
    lowpass: FloatArray,
    rest: FloatArray,
) -> None:
    """One update with the accelerometer, in place.

    Parameters
    ----------
    own : (4,) attitude.  tilt : by how much gravity corrected it: the horizontal part of the unit vertical before.
    interval_s : since the previous sample, positive.  gain : of the low-pass that gravity went through.
    at_rest : use the mean rate, not the tilt.
    bias, covariance : (3,) rad/s and (3, 3), changed in place.
    lowpass : (2, 11) rotation matrix and horizontal bias through the same low-pass as gravity, changed in place.
    rest : (2, 6) as in notice_rest.
    """
    w, x, y, z = own[0], own[1], own[2], own[3]
    first = (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y))
    second = (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x))
    third = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    turned_x = first[0] * bias[0] + first[1] * bias[1] + first[2] * bias[2]
    turned_y = second[0] * bias[0] + second[1] * bias[1] + second[2] * bias[2]
    for k, value in enumerate(first + second + third + (turned_x, turned_y)):
        lowpass[0, k] += gain * (value - lowpass[0, k])
        lowpass[1, k] += gain * (lowpass[0, k] - lowpass[1, k])
    drift = BIAS_DRIFT * interval_s
    for k in range(3):
        covariance[k, k] = min(covariance[k, k] + drift, BIAS_START**2)
    start_x, start_y, start_z = bias[0], bias[1], bias[2]
    for i in range(3):  # three scalar updates equal the joint one: their noises are independent
        if at_rest:
            a, b, c = 1.0 * (i == 0), 1.0 * (i == 1), 1.0 * (i == 2)
            error = rest[0, i] - (a * start_x + b * start_y + c * start_z)
            noise = BIAS_REST**2 / drift + BIAS_REST
        else:
            a, b, c = lowpass[1, 3 * i], lowpass[1, 3 * i + 1], lowpass[1, 3 * i + 2]
            error = -(a * start_x + b * start_y + c * start_z)
            noise = BIAS_MOTION**2 / drift + BIAS_MOTION
            if i == 0:
                error += -tilt[1] / interval_s + lowpass[1, 9]
            elif i == 1:
                error += tilt[0] / interval_s + lowpass[1, 10]
            else:
                noise /= BIAS_VERTICAL
        error = min(max(error, -BIAS_LIMIT), BIAS_LIMIT)
        error -= a * (bias[0] - start_x) + b * (bias[1] - start_y) + c * (bias[2] - start_z)
        p0 = covariance[0, 0] * a + covariance[0, 1] * b + covariance[0, 2] * c
        p1 = covariance[1, 0] * a + covariance[1, 1] * b + covariance[1, 2] * c
        p2 = covariance[2, 0] * a + covariance[2, 1] * b + covariance[2, 2] * c
        total = a * p0 + b * p1 + c * p2 + noise
        bias[0] += p0 / total * error
        bias[1] += p1 / total * error
        bias[2] += p2 / total * error
        column = (p0, p1, p2)
        for j in range(3):
            for k in range(3):
                covariance[j, k] -= column[j] * column[k] / total
    for k in range(3):
        bias[k] = min(max(bias[k], -BIAS_LIMIT), BIAS_LIMIT)
