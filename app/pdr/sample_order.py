"""The samples of all inertial streams in the order of time."""

from __future__ import annotations

import math

from numba import njit

from app.estimation.arrays import FloatArray

ACC, GYR, MAG, ROT = range(4)
"""Accelerometer, gyroscope, magnetometer, rotation vector: the elements of a filter's `time_s`."""


@njit(cache=True)
def next_sample(
    acc_time_s: FloatArray,
    a: int,
    gyr_time_s: FloatArray,
    g: int,
    mag_time_s: FloatArray,
    m: int,
    rot_time_s: FloatArray,
    r: int,
) -> tuple[int, float]:
    """Stream of the next sample and its time (s), infinite after the last. At equal times the accelerometer comes last,
    so that it meets what the others say of that moment.

    Parameters
    ----------
    acc_time_s, gyr_time_s, mag_time_s, rot_time_s : (n,) each its own length, seconds, non-decreasing.
    a, g, m, r : how many of each have been taken.
    """
    stream, at_s = ACC, acc_time_s[a] if a < len(acc_time_s) else math.inf
    if r < len(rot_time_s) and rot_time_s[r] <= at_s:
        stream, at_s = ROT, rot_time_s[r]
    if m < len(mag_time_s) and mag_time_s[m] <= at_s:
        stream, at_s = MAG, mag_time_s[m]
    if g < len(gyr_time_s) and gyr_time_s[g] <= at_s:
        stream, at_s = GYR, gyr_time_s[g]
    return stream, at_s
