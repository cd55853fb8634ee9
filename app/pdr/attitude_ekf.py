"""Attitude by the two-stage paper's first extended filter: heading, pitch and roll from gyroscope and accelerometer.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, Eq. 9-17 (docs/methods/two_stage_ekf.md). Pitch is
about the device's x axis, roll about its y axis, heading clockwise, as Eq. 12 has it.

Differs from the paper: its Eq. 16 turns pitch and roll about each other's axes, so that gravity would pull the angles
away from those that Eq. 12 integrates; Eq. 15 is used with the axes of Eq. 12. The start is level with the first
acceleration, not known. Near an upright phone, where pitch and roll of Eq. 12 run to infinity, the cosine of the pitch
counts as at least LEAST_COSINE.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.observations import Batch
from app.pdr.gravity import GRAVITY_MPS2
from app.pdr.tracker import fresh_samples

LEAST_COSINE = 0.05
LIMIT_RAD_PER_S = 40.0
"""A phone's gyroscope ends at 35."""
UNKNOWN_RAD2 = 1e6
"""A covariance that grew beyond this, by a phone spun upright, says nothing: back to that of a start."""
GAP_S = 1.0
"""After a longer gap in the gyroscope nothing is known of the turns in it: another `stretch` begins."""
REMEMBERED_S, APART_S = 4.0, 0.02
"""Steps are told up to some three seconds late; their headings are looked up among those remembered."""
GYR_S, ACC_S, HEADING, PITCH, ROLL, RATE_X, RATE_Y, RATE_Z, STRETCH, NOTED_S = range(10)


@dataclass(frozen=True, slots=True)
class AttitudeNoise:
    """Variances of one sample: process (rad^2) of each angle, measurement (g^2) of each axis.

    Of 50 samples a second, ours forget a tilt in about two seconds. PAPER_ATTITUDE: Eq. 13 and 17, which follow every
    jolt of the accelerometer.
    """

    process_rad2: float = 1e-4
    measurement_g2: float = 1.0


PAPER_ATTITUDE = AttitudeNoise(1.0, 1.0)


def _unknown() -> FloatArray:
    values = np.zeros(10)
    values[[GYR_S, ACC_S, NOTED_S]] = -math.inf
    return values


@dataclass(frozen=True, slots=True, eq=False)
class EulerState:
    """values : (10,) newest gyroscope and accelerometer sample (s), heading, pitch and roll (rad, the heading
    unwrapped and from an arbitrary zero), newest rates (rad/s), number of the stretch without a gap, newest time noted.
    covariance : (3, 3), rad^2.  noted : (n, 2) times and headings of the last REMEMBERED_S.
    """

    values: FloatArray = field(default_factory=_unknown)
    covariance: FloatArray = field(default_factory=lambda: np.eye(3))
    noted: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def stretch(self) -> int:
        """Headings of different stretches have nothing to do with each other."""
        return int(self.values[STRETCH])

    def heading_at(self, time_s: float) -> float | None:
        """Heading from this state's own zero, unwrapped (rad); the nearest remembered for a time that is not. None
        before the first sample."""
        if not len(self.noted):
            return None
        return float(np.interp(time_s, self.noted[:, 0], self.noted[:, 1]))


def advance_attitude(state: EulerState, batch: Batch, noise: AttitudeNoise, until_s: float | None = None) -> EulerState:
    """The state after the batch's samples of gyroscope and accelerometer that are newer than those seen.

    Parameters
    ----------
    until_s : leave samples later than this for a later call with the same batch.
    """
    gyr_time_s, gyr = fresh_samples(batch.gyroscope, float(state.values[GYR_S]), until_s)
    acc_time_s, acc = fresh_samples(batch.accelerometer, float(state.values[ACC_S]), until_s)
    if not (len(gyr_time_s) or len(acc_time_s)):
        return state
    values, covariance = state.values.copy(), state.covariance.copy()
    new = np.empty((len(gyr_time_s), 2))
    count = filtered(
        values, covariance, gyr_time_s, gyr, acc_time_s, acc, noise.process_rad2, noise.measurement_g2, new
    )
    # headings across a gap do not go on from each other
    kept = state.noted if values[STRETCH] == state.values[STRETCH] else state.noted[:0]
    noted = np.concatenate([kept, new[:count]])
    if len(noted):
        noted = noted[np.searchsorted(noted[:, 0], noted[-1, 0] - REMEMBERED_S) :]
    return EulerState(values, covariance, noted)


@njit(cache=True)
def filtered(
    values: FloatArray,
    covariance: FloatArray,
    gyr_time_s: FloatArray,
    gyr: FloatArray,
    acc_time_s: FloatArray,
    acc: FloatArray,
    process_rad2: float,
    measurement_g2: float,
    noted: FloatArray,
) -> int:
    """Advance the filter over both streams in the order of time; at equal times the gyroscope comes first.

    Parameters
    ----------
    values, covariance : (10,), (3, 3) as in EulerState, changed in place.
    gyr_time_s, acc_time_s : (n,), (m,) seconds.  gyr, acc : (n, 3), (m, 3) rad/s and m/s^2.
    noted : (n, 2) written: time and heading, APART_S apart or more.

    Returns
    -------
    How many rows were noted.
    """
    count = 0
    g = a = 0
    while g < len(gyr_time_s) or a < len(acc_time_s):
        if a == len(acc_time_s) or (g < len(gyr_time_s) and gyr_time_s[g] <= acc_time_s[a]):
            now = gyr_time_s[g]
            interval_s = now - values[GYR_S]
            if interval_s > GAP_S:
                values[STRETCH] += 1.0
                values[NOTED_S], count = -math.inf, 0
            else:
                turn(values, covariance, gyr[g], interval_s, process_rad2)
            values[RATE_X], values[RATE_Y], values[RATE_Z] = gyr[g, 0], gyr[g, 1], gyr[g, 2]
            values[GYR_S], g = now, g + 1
            if now - values[NOTED_S] >= APART_S - 1e-9:
                noted[count, 0], noted[count, 1] = now, values[HEADING]
                values[NOTED_S], count = now, count + 1
        else:
            if acc_time_s[a] - values[ACC_S] > GAP_S:
                _level(values, covariance, acc[a])
            else:
                lean(values, covariance, acc[a], measurement_g2)
            values[ACC_S], a = acc_time_s[a], a + 1
    return count


@njit(cache=True)
def turn(values: FloatArray, covariance: FloatArray, rate: FloatArray, interval_s: float, process_rad2: float) -> None:
    """Eq. 12 over the mean rate (3,) of an interval, and its Jacobian over the covariance."""
    x = _limited(0.5 * (values[RATE_X] + rate[0]))
    y = _limited(0.5 * (values[RATE_Y] + rate[1]))
    z = _limited(0.5 * (values[RATE_Z] + rate[2]))
    sine, cosine = math.sin(values[ROLL]), math.cos(values[ROLL])
    pitch_cosine = math.cos(values[PITCH])
    if abs(pitch_cosine) < LEAST_COSINE:
        pitch_cosine = math.copysign(LEAST_COSINE, pitch_cosine)
    tangent = math.sin(values[PITCH]) / pitch_cosine
    about, along = sine * x - cosine * z, cosine * x + sine * z
    f = np.eye(3)
    f[0, 1] = interval_s * about * tangent / pitch_cosine
    f[0, 2] = interval_s * along / pitch_cosine
    f[1, 2] = -interval_s * about
    f[2, 1] = interval_s * about / (pitch_cosine * pitch_cosine)
    f[2, 2] = 1.0 + interval_s * along * tangent
    covariance[:, :] = f @ covariance @ f.T
    for k in range(3):
        covariance[k, k] += process_rad2
    if not covariance[0, 0] + covariance[1, 1] + covariance[2, 2] < UNKNOWN_RAD2:
        _begin(covariance)
    values[HEADING] += interval_s * about / pitch_cosine
    values[PITCH] = wrap(values[PITCH] + interval_s * along)
    values[ROLL] = wrap(values[ROLL] + interval_s * (y + about * tangent))


@njit(cache=True)
def lean(values: FloatArray, covariance: FloatArray, force: FloatArray, measurement_g2: float) -> None:
    """Eq. 15: the accelerometer (3,), m/s^2, as gravity in the device frame. Its axes' noises are independent, so three
    scalar corrections are the joint one."""
    pitch, roll = values[PITCH], values[ROLL]
    sp, cp, sr, cr = math.sin(pitch), math.cos(pitch), math.sin(roll), math.cos(roll)
    expected = (-sr * cp, sp, cr * cp)
    by_pitch, by_roll = (sr * sp, cp, -cr * sp), (-cr * cp, 0.0, -sr * cp)
    correction = np.zeros(3)
    for axis in range(3):
        p, r = by_pitch[axis], by_roll[axis]
        column = covariance[:, 1] * p + covariance[:, 2] * r
        total = column[1] * p + column[2] * r + measurement_g2
        error = force[axis] / GRAVITY_MPS2 - expected[axis] - p * correction[1] - r * correction[2]
        for i in range(3):
            correction[i] += column[i] / total * error
        for i in range(3):
            for j in range(3):
                covariance[i, j] -= column[i] * column[j] / total
    values[HEADING] += correction[0]
    values[PITCH] = wrap(pitch + correction[1])
    values[ROLL] = wrap(roll + correction[2])


@njit(cache=True)
def _level(values: FloatArray, covariance: FloatArray, force: FloatArray) -> None:
    """Pitch and roll of one acceleration."""
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size > 1.0:
        values[PITCH] = math.asin(min(max(force[1] / size, -1.0), 1.0))
        values[ROLL] = math.atan2(-force[0], force[2])
    _begin(covariance)


@njit(cache=True)
def _begin(covariance: FloatArray) -> None:
    """The uncertainty of a start, Eq. 11."""
    for i in range(3):
        for j in range(3):
            covariance[i, j] = 1.0 * (i == j)


@njit(cache=True)
def _limited(rate_rad_per_s: float) -> float:
    return min(max(rate_rad_per_s, -LIMIT_RAD_PER_S), LIMIT_RAD_PER_S)
