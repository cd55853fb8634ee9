"""Which magnetic field to trust, and how far to follow it.

Magnetic disturbance rejection of VQF (Laidig and Seel 2023, doi:10.1016/j.inffus.2022.10.014, section 3.5) by the
field's norm and dip, with its time constants.

Differs from the paper: the compass is followed without regard to its field while there is no gyroscope to replace it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import DEGREE, wrap
from app.estimation.arrays import FloatArray

TAU_COMPASS_S, TAU_COMPASS_NO_GYRO_S = 9.0, 1.0
FIELD_SHARE, FIELD_DIP = 0.10, 10.0 * DEGREE
TAU_FIELD_S, TAU_FIELD_REFERENCE_S, FIELD_CALM_S = 0.05, 20.0, 0.5
FIELD_NEW_S, FIELD_FIRST_S, FIELD_REJECT_S = 20.0, 5.0, 60.0
LEAST_FIELD_UT, MOST_FIELD_UT = 10.0, 120.0
"""The earth's field is of 22 to 67 uT, and of 20 to 110 near steel in the recorded mall. What is beyond is a magnet at
the phone, or a sensor that nobody calibrated: it turns with the phone, and is no compass."""
FOREIGN_SHARE, FOREIGN_DIP = 0.35, 25.0 * DEGREE
"""Away from the trusted field by so much a bearing says nothing. With 0.25 and 20 degrees a broken gyroscope is noticed
later, and weak magnets do as much harm."""
DRIFT_VARIANCE = 0.02**2
"""rad^2/s by which the heading's variance grows while the compass is not believed."""

DELTA, START_GAIN, NORM, DIP, NORM_REF, DIP_REF, NORM_NEW, DIP_NEW, NEW_S, CALM_S, REJECT_S, BEARING = range(12)
"""Rows of the magnetic state: heading offset, gain at the start, field now, trusted, candidate, timers, bearing."""


def no_compass_yet() -> FloatArray:
    """The magnetic state (12,) before the first sample."""
    values = np.zeros(12)
    values[START_GAIN], values[REJECT_S], values[BEARING] = 1.0, FIELD_REJECT_S, math.nan
    return values


@njit(cache=True)
def trust_field(interval_s: float, norm_ut: float, dip_rad: float, turning: bool, magnetic: FloatArray) -> None:
    """Keep the trusted field's norm and dip, and how long the present one has agreed with it."""
    gain = -math.expm1(-interval_s / TAU_FIELD_S) if magnetic[NORM] > 0.0 else 1.0
    magnetic[NORM] += gain * (norm_ut - magnetic[NORM])
    magnetic[DIP] += gain * (dip_rad - magnetic[DIP])
    calm = abs(magnetic[NORM] - magnetic[NORM_REF]) < FIELD_SHARE * magnetic[NORM_REF]
    calm = calm and abs(magnetic[DIP] - magnetic[DIP_REF]) < FIELD_DIP
    slow_gain = -math.expm1(-interval_s / TAU_FIELD_REFERENCE_S)
    if calm:
        magnetic[CALM_S] += interval_s
        if magnetic[CALM_S] >= FIELD_CALM_S:
            magnetic[NORM_REF] += slow_gain * (magnetic[NORM] - magnetic[NORM_REF])
            magnetic[DIP_REF] += slow_gain * (magnetic[DIP] - magnetic[DIP_REF])
    else:
        magnetic[CALM_S] = 0.0
    # another field becomes the trusted one when it has held still for long enough while the phone turned
    steady = abs(magnetic[NORM] - magnetic[NORM_NEW]) < FIELD_SHARE * magnetic[NORM_NEW]
    if steady and abs(magnetic[DIP] - magnetic[DIP_NEW]) < FIELD_DIP:
        magnetic[NEW_S] += interval_s if turning else 0.0
        magnetic[NORM_NEW] += slow_gain * (magnetic[NORM] - magnetic[NORM_NEW])
        magnetic[DIP_NEW] += slow_gain * (magnetic[DIP] - magnetic[DIP_NEW])
        if not calm and magnetic[NEW_S] >= (FIELD_FIRST_S if magnetic[NORM_REF] == 0.0 else FIELD_NEW_S):
            magnetic[NORM_REF], magnetic[DIP_REF], magnetic[CALM_S] = (
                magnetic[NORM_NEW],
                magnetic[DIP_NEW],
                FIELD_CALM_S,
            )
    else:
        magnetic[NEW_S], magnetic[NORM_NEW], magnetic[DIP_NEW] = 0.0, magnetic[NORM], magnetic[DIP]


@njit(cache=True)
def is_foreign(magnetic: FloatArray) -> bool:
    """Whether the field is so far from the trusted one that its bearing says nothing: a magnet turns with the phone."""
    known = magnetic[NORM_REF] > 0.0
    strange = abs(magnetic[NORM] - magnetic[NORM_REF]) > FOREIGN_SHARE * magnetic[NORM_REF]
    return bool(known and (strange or abs(magnetic[DIP] - magnetic[DIP_REF]) > FOREIGN_DIP))


@njit(cache=True)
def follow_compass(north_rad: float, interval_s: float, has_rate: bool, drift: float, magnetic: FloatArray) -> float:
    """Move the heading offset towards the compass, as far as its field is trusted.

    north_rad : azimuth of the field in the frame of the own filter.  drift : variance (rad^2) that the heading gained
    without compass; returned as it is after.
    """
    gain = -math.expm1(-interval_s / (TAU_COMPASS_S if has_rate else TAU_COMPASS_NO_GYRO_S))
    if has_rate:
        if magnetic[CALM_S] >= FIELD_CALM_S:
            magnetic[REJECT_S] = max(magnetic[REJECT_S] - 2.0 * interval_s, 0.0)
        elif magnetic[REJECT_S] < FIELD_REJECT_S:
            magnetic[REJECT_S] += interval_s
            gain = 0.0
            drift += DRIFT_VARIANCE * interval_s
        else:
            gain *= 0.5
    drift *= 1.0 - gain
    if magnetic[START_GAIN] > 0.0:  # at first the plain mean of all samples
        if magnetic[START_GAIN] == 1.0:
            drift = 0.0
        gain = max(gain, magnetic[START_GAIN])
        magnetic[START_GAIN] /= magnetic[START_GAIN] + 1.0
        if magnetic[START_GAIN] * TAU_COMPASS_S < interval_s:
            magnetic[START_GAIN] = 0.0
    magnetic[DELTA] = wrap(magnetic[DELTA] + gain * wrap(-north_rad - magnetic[DELTA]))
    return drift
