"""Attitude from gyroscope, accelerometer and magnetometer, sample by sample, at whatever rates they come.

The structure is that of VQF (Laidig and Seel, Information Fusion 91, 2023, doi:10.1016/j.inffus.2022.10.014): the
gyroscope alone is integrated; the acceleration, averaged in that slowly drifting frame, corrects the inclination only;
the magnetometer corrects the heading only. What steel does to the compass so never tilts the horizon, and the turn by
the gyroscope alone stays available beside the compass.

Differs from the paper: low-pass filters are two cascaded exponentials whose gains follow from each sample's own
interval (phones jitter); without a gyroscope the same equations run with short time constants, a tilt-compensated
compass; Android's rotation vector, where sent, replaces the heading and the own filter follows it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import DEGREE, wrap
from app.estimation.arrays import FloatArray
from app.pdr.attitude_state import DRIFT, LEVEL_S, POINTED, REST_S, TURN
from app.pdr.carrying_position import FACES_UP
from app.pdr.compass import (
    BEARING,
    DELTA,
    DRIFT_VARIANCE,
    FIELD_REJECT_S,
    LEAST_FIELD_UT,
    MOST_FIELD_UT,
    REJECT_S,
    START_GAIN,
    follow_compass,
    is_foreign,
    trust_field,
)
from app.pdr.gyroscope_bias import REST_AFTER_S, TAU_REST_S, learn_bias, notice_rest
from app.pdr.gyroscope_stuck import gyroscope_stuck, notice_repeats
from app.pdr.quaternion import azimuth, multiply, of_rotation_vector, rotate, turn_by
from app.pdr.sample_order import ACC, GYR, MAG, ROT, next_sample

TAU_GRAVITY_S, TAU_GRAVITY_NO_GYRO_S = 3.0, 0.6
TURNING = 20.0 * DEGREE
"""rad/s: a steady magnetic field proves itself only while the phone turns faster."""
STALE_S = 0.5
"""A stream silent for longer is treated as absent until it comes back."""
GAP_S = 1.0
"""After a longer gap nothing is known of the turns in it: level and heading start again from the next samples."""

SIGMA_ROTATION_VECTOR, SIGMA_COMPASS, SIGMA_NO_GYRO = 0.24, 0.24, 0.35
"""Of a step's heading against the way between waypoints, mall walks of folds 1-4: 68 % lie within."""

SIZE, HEADING, VARIANCE, TURNED, COMPASS, RATE, VERTICAL = range(7)
"""Columns of `track`'s answer."""
ALONG, ACROSS = range(2)
"""Columns of what it says of sway."""


@njit(cache=True)
def _gain(interval_s: float, tau_s: float, elapsed_s: float) -> float:
    """Gain of an exponential low-pass, no less than that of the plain mean while it has just begun."""
    gain = -math.expm1(-interval_s / tau_s)
    return max(gain, interval_s / elapsed_s) if elapsed_s > interval_s else 1.0


@njit(cache=True)
def _on_rate(
    sample: FloatArray,
    row: int,
    interval_s: float,
    rate: FloatArray,
    strapdown: FloatArray,
    inclination: FloatArray,
    scalars: FloatArray,
    bias: FloatArray,
    rest: FloatArray,
    work: FloatArray,
) -> None:
    """Integrate one sample of the gyroscope."""
    if interval_s > 0.0:
        # mean of both ends of the interval, bias removed
        for k in range(3):
            work[k] = 0.5 * (rate[k] + sample[row, k]) - bias[k]
        turn_by(strapdown, work[0] * interval_s, work[1] * interval_s, work[2] * interval_s)
        rotate(strapdown, work, work)
        rotate(inclination, work, work)
        scalars[TURN] -= work[2] * interval_s
        gain = -math.expm1(-interval_s / TAU_REST_S)
        for k in range(3):
            rest[0, k] += gain * (sample[row, k] - rest[0, k])
            rest[1, k] = sample[row, k]
    for k in range(3):
        rate[k] = sample[row, k]


@njit(cache=True)
def _level(
    sample: FloatArray,
    row: int,
    interval_s: float,
    has_rate: bool,
    strapdown: FloatArray,
    inclination: FloatArray,
    gravity: FloatArray,
    scalars: FloatArray,
    work: FloatArray,
    correction: FloatArray,
) -> tuple[float, tuple[float, float]]:
    """Turn the inclination to the mean acceleration; gives the gain used and the misalignment found, (0, 0) if none."""
    scalars[LEVEL_S] += interval_s
    gain = _gain(interval_s, 0.5 * (TAU_GRAVITY_S if has_rate else TAU_GRAVITY_NO_GYRO_S), scalars[LEVEL_S])
    for k in range(3):
        work[k] = sample[row, k]
    rotate(strapdown, work, work)
    for k in range(3):
        gravity[0, k] += gain * (work[k] - gravity[0, k])
        gravity[1, k] += gain * (gravity[0, k] - gravity[1, k])
        work[k] = gravity[1, k]
    rotate(inclination, work, work)
    size = math.sqrt(work[0] ** 2 + work[1] ** 2 + work[2] ** 2)
    if size < 1.0:  # free fall or a dead sensor tells no direction
        return gain, (0.0, 0.0)
    x, y, w = work[0] / size, work[1] / size, math.sqrt(max((work[2] / size + 1.0) / 2.0, 0.0))
    if w > 1e-6:
        correction[0], correction[1], correction[2] = w, y / (2.0 * w), -x / (2.0 * w)
    else:  # upside down: about any horizontal axis
        correction[0], correction[1], correction[2] = 0.0, 1.0, 0.0
    multiply(correction, inclination, inclination)
    return gain, (x, y)


@njit(cache=True)
def track(
    arrays: tuple[FloatArray, ...],
    acc_time_s: FloatArray,
    acc: FloatArray,
    gyr_time_s: FloatArray,
    gyr: FloatArray,
    mag_time_s: FloatArray,
    mag: FloatArray,
    rot_time_s: FloatArray,
    rot: FloatArray,
    answer: FloatArray,
    swayed: FloatArray,
) -> None:
    """Advance the filter over the samples of all streams in the order of time.

    Parameters
    ----------
    arrays : the twelve arrays of AttitudeState, changed in place. At equal times the accelerometer comes last.
    acc_time_s, gyr_time_s, mag_time_s, rot_time_s : (n,) each its own length, seconds, non-decreasing, none older than
        the newest already processed of its stream.
    acc, gyr, mag, rot : (n, 3) m/s^2, rad/s, microtesla, quaternion x y z.
    answer : (n_acc, 7) written: norm of the acceleration, heading (rad, clockwise from north), its variance (without
        any absolute reference pi^2), accumulated turn by the gyroscope (without one: by the heading), bearing by the
        compass (NaN without), norm of the angular rate, acceleration along gravity.
    swayed : (n_acc, 2) written: acceleration along where the phone points and to the right of it, m/s^2; NaN of a phone
        whose screen does not face up.
    """
    time_s, rate, strapdown, inclination, gravity, scalars, bias, covariance, lowpass, rest, magnetic, anchor = arrays
    work, own, since, correction = np.zeros(3), np.zeros(4), np.zeros(4), np.zeros(4)
    then, given = anchor[1], anchor[0]
    a = g = m = r = 0
    while True:
        stream, now = next_sample(acc_time_s, a, gyr_time_s, g, mag_time_s, m, rot_time_s, r)
        if now == math.inf:
            break
        has_rate = now - time_s[GYR] < STALE_S and not gyroscope_stuck(scalars, rest, magnetic)
        has_rotation = now - time_s[ROT] < STALE_S
        if stream == GYR:
            interval_s = now - time_s[GYR]
            if interval_s > GAP_S:
                scalars[LEVEL_S], interval_s = 0.0, 0.0
                magnetic[START_GAIN], magnetic[REJECT_S] = 1.0, FIELD_REJECT_S
            notice_repeats(gyr, g, interval_s, rate, rest)
            if not gyroscope_stuck(scalars, rest, magnetic):
                _on_rate(gyr, g, interval_s, rate, strapdown, inclination, scalars, bias, rest, work)
            time_s[GYR], g = now, g + 1
        elif stream == MAG:
            interval_s = min(now - time_s[MAG], GAP_S)
            multiply(inclination, strapdown, own)
            for k in range(3):
                work[k] = mag[m, k]
            rotate(own, work, work)
            norm = math.sqrt(work[0] ** 2 + work[1] ** 2 + work[2] ** 2)
            if LEAST_FIELD_UT < norm < MOST_FIELD_UT:
                north = math.atan2(work[0], work[1])
                turning = rate[0] ** 2 + rate[1] ** 2 + rate[2] ** 2 >= TURNING**2
                trust_field(interval_s, norm, -math.asin(min(max(work[2] / norm, -1.0), 1.0)), turning, magnetic)
                magnetic[BEARING] = math.nan if has_rate and is_foreign(magnetic) else wrap(azimuth(own) - north)
                if not has_rotation:
                    scalars[DRIFT] = follow_compass(north, interval_s, has_rate, scalars[DRIFT], magnetic)
            else:
                magnetic[BEARING] = math.nan
            time_s[MAG], m = now, m + 1
        elif stream == ROT:
            of_rotation_vector(rot[r], given)
            multiply(inclination, strapdown, then)
            # the own filter follows, so that nothing jumps when this stream ends
            magnetic[DELTA] = wrap(azimuth(given) - azimuth(then))
            magnetic[START_GAIN], scalars[DRIFT] = 0.0, 0.0
            time_s[ROT], r = now, r + 1
        else:
            interval_s = now - time_s[ACC]
            if interval_s > GAP_S:
                scalars[LEVEL_S], interval_s = 0.0, 0.02
                for k in range(3):
                    rest[0, k], rest[0, 3 + k] = rate[k], acc[a, k]
            gain, tilt = _level(
                acc, a, interval_s, has_rate, strapdown, inclination, gravity, scalars, work, correction
            )
            multiply(inclination, strapdown, own)
            if has_rate and interval_s > 0.0:
                scalars[REST_S] = notice_rest(acc, a, interval_s, scalars[REST_S], rest)
                still = scalars[REST_S] >= REST_AFTER_S
                learn_bias(own, tilt, interval_s, gain, still, bias, covariance, lowpass, rest)
            for k in range(3):
                work[k] = acc[a, k]
            rotate(own, work, work)
            points, faces = azimuth(own), 1.0 - 2.0 * (own[1] ** 2 + own[2] ** 2)
            east, north = (work[0], work[1]) if faces > FACES_UP else (math.nan, math.nan)
            swayed[a, ALONG] = east * math.sin(points) + north * math.cos(points)
            swayed[a, ACROSS] = east * math.cos(points) - north * math.sin(points)
            has_field = now - time_s[MAG] < STALE_S and not math.isnan(magnetic[BEARING])
            if has_rotation:
                if has_rate:  # turned since by the gyroscope
                    since[0], since[1], since[2], since[3] = then[0], -then[1], -then[2], -then[3]
                    multiply(since, own, since)
                    multiply(given, since, own)
                    heading = azimuth(own)
                else:
                    heading = azimuth(given)
                variance = SIGMA_ROTATION_VECTOR**2
            else:
                heading = wrap(points + magnetic[DELTA])
                if not has_field:
                    scalars[DRIFT] += DRIFT_VARIANCE * interval_s
                absolute = magnetic[START_GAIN] < 1.0 and (has_rate or has_field)
                floor = SIGMA_COMPASS if has_rate else SIGMA_NO_GYRO
                variance = min(floor**2 + scalars[DRIFT], math.pi**2) if absolute else math.pi**2
            if not has_rate:
                scalars[TURN] += wrap(heading - scalars[POINTED])
            scalars[POINTED] = heading
            answer[a, SIZE] = math.sqrt(acc[a, 0] ** 2 + acc[a, 1] ** 2 + acc[a, 2] ** 2)
            answer[a, HEADING], answer[a, VARIANCE], answer[a, TURNED] = heading, variance, scalars[TURN]
            answer[a, COMPASS] = magnetic[BEARING] if has_field else math.nan
            answer[a, RATE] = math.sqrt(rate[0] ** 2 + rate[1] ** 2 + rate[2] ** 2) if has_rate else 0.0
            answer[a, VERTICAL] = work[2]
            time_s[ACC], a = now, a + 1
