"""What a phone feels, wherever it is carried, turned into east, north and up: the last seconds of it.

The samples of all sensors go through the quaternion filter in the order of time; what the paper's later parts need of
them is kept in rings.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.pdr.carried_state import (
    ABSOLUTE,
    CELL,
    CELL_S,
    CELLS,
    CELLS_A_POSE,
    DIP_REF,
    EAST,
    FACES,
    FIELD_S,
    IN_CELL,
    KEPT,
    NORM,
    NORM_REF,
    NORTH,
    POINTED,
    POINTS,
    POSE_COVARIANCE,
    POSE_Q,
    POSE_TIME,
    POSED,
    POSES,
    SEEKS_NORTH,
    STARTED,
    TIME,
    TURN,
    TURNED,
    UP,
)
from app.pdr.gravity import GRAVITY_MPS2
from app.pdr.quaternion import azimuth, of_rotation_vector, rotate
from app.pdr.quaternion_ukf import (
    face_north,
    level,
    predict,
    seen_by_device,
    turn_covariance,
    turn_of,
    update,
)
from app.pdr.sample_order import ACC, GYR, MAG, ROT, next_sample

GAP_S, STALE_S = 1.0, 0.5
START_TILT_RAD, START_AZIMUTH_RAD, LARGEST_RAD2 = 0.3, 0.5, 3.0
TAU_FIELD_S = 20.0
LEAST_INTERVAL_S, LARGEST_INTERVAL_S = 0.002, 0.2


@njit(cache=True)
def _see_field(
    field_seen: FloatArray, interval_s: float, noise: FloatArray, q: FloatArray, covariance: FloatArray, s: FloatArray
) -> None:
    """Take one sample of the magnetometer, less seriously the less its field is like the site's."""
    norm = math.sqrt(field_seen[0] ** 2 + field_seen[1] ** 2 + field_seen[2] ** 2)
    if norm < 1.0:
        return
    turned = np.empty(3)
    rotate(q, field_seen, turned)
    dip = -math.asin(min(max(turned[2] / norm, -1.0), 1.0))
    s[FIELD_S] += interval_s
    gain = 1.0 if s[NORM_REF] == 0.0 else max(-math.expm1(-interval_s / TAU_FIELD_S), interval_s / s[FIELD_S])
    s[NORM_REF] += gain * (norm - s[NORM_REF])
    s[DIP_REF] += gain * (dip - s[DIP_REF])
    odd = ((norm / s[NORM_REF] - 1.0) / noise[5]) ** 2 + ((dip - s[DIP_REF]) / noise[6]) ** 2
    _face(field_seen / norm, s[DIP_REF], noise[4] * (1.0 + odd) / interval_s, q, covariance, s)


@njit(cache=True)
def _face(
    direction: FloatArray, dip_rad: float, variance: float, q: FloatArray, covariance: FloatArray, s: FloatArray
) -> None:
    """Correct by the direction of north, or take it over where there was none yet."""
    if s[SEEKS_NORTH] > 0.0:
        turn = turn_of(q, covariance)
        face_north(direction, q)
        turn[2, :], turn[:, 2] = 0.0, 0.0
        turn[2, 2] = START_AZIMUTH_RAD**2
        covariance[:] = turn_covariance(q, turn)
        s[SEEKS_NORTH], s[ABSOLUTE] = 0.0, 1.0
        return
    update(q, covariance, direction, np.array([0.0, math.cos(dip_rad), -math.sin(dip_rad)]), variance)


@njit(cache=True)
def _keep(
    now_s: float, q: FloatArray, covariance: FloatArray, s: FloatArray, sums: FloatArray, cells: FloatArray,
    poses: FloatArray,
) -> None:  # fmt: skip
    """Close the open cell, and note a pose every few cells."""
    count = s[IN_CELL]
    cell = cells[int(s[KEPT]) % CELLS]
    for k in range(FACES + 1):
        cell[k] = sums[k] / count
    cell[TURNED] = s[TURN]
    cell[POINTS] = math.atan2(sums[FACES + 1], sums[FACES + 2])
    s[KEPT] += 1.0
    if int(s[KEPT]) % CELLS_A_POSE == 0:
        pose = poses[int(s[POSED]) % POSES]
        pose[POSE_TIME] = now_s
        pose[POSE_Q:POSE_COVARIANCE] = q
        pose[POSE_COVARIANCE:] = covariance.reshape(16)
        s[POSED] += 1.0
    sums[:] = 0.0
    s[IN_CELL] = 0.0


@njit(cache=True)
def _feel(
    now_s: float, force: FloatArray, interval_s: float, noise: FloatArray, q: FloatArray, covariance: FloatArray,
    s: FloatArray, sums: FloatArray, cells: FloatArray, poses: FloatArray,
) -> None:  # fmt: skip
    """Take one sample of the accelerometer: it corrects the attitude, then goes into its cell."""
    if s[IN_CELL] > 0.0 and math.floor(now_s / CELL_S) != s[CELL]:
        _keep(now_s, q, covariance, s, sums, cells, poses)
    s[CELL] = math.floor(now_s / CELL_S)
    norm = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    variance = noise[2] * (1.0 + ((norm - GRAVITY_MPS2) / noise[3]) ** 2) / interval_s
    update(q, covariance, force, np.array([0.0, 0.0, GRAVITY_MPS2]), variance)
    turned = np.empty(3)
    rotate(q, force, turned)
    points = azimuth(q)
    s[IN_CELL] += 1.0
    sums[TIME] += now_s
    sums[EAST] += turned[0]
    sums[NORTH] += turned[1]
    sums[UP] += turned[2] - GRAVITY_MPS2
    sums[NORM] += norm
    sums[FACES] += 1.0 - 2.0 * (q[1] ** 2 + q[2] ** 2)
    sums[FACES + 1] += math.sin(points)
    sums[FACES + 2] += math.cos(points)


@njit(cache=True)
def carry(
    arrays: tuple[FloatArray, ...],
    noise: FloatArray,
    acc_time_s: FloatArray,
    acc: FloatArray,
    gyr_time_s: FloatArray,
    gyr: FloatArray,
    mag_time_s: FloatArray,
    mag: FloatArray,
    rot_time_s: FloatArray,
    rot: FloatArray,
) -> None:
    """Take the samples of all streams in the order of time.

    Parameters
    ----------
    arrays : the eight arrays of CarriedMotion, changed in place.  noise : (7,) as of QuaternionNoise.values().
    acc_time_s, gyr_time_s, mag_time_s, rot_time_s : (n,) each its own length, seconds, non-decreasing, none older than
        the newest already taken of its stream.
    acc, gyr, mag, rot : (n, 3) m/s^2, rad/s, microtesla, quaternion x y z.

    Notes
    -----
    The paper's phones have a gyroscope and a magnetometer. Without the first a turn is unseen and so much more likely;
    without the second Android's rotation vector, where there is one, says where north is.
    """
    time_s, rate, q, covariance, s, sums, cells, poses = arrays
    work, given = np.empty(3), np.empty(4)
    north = np.array([0.0, 1.0, 0.0])
    a = g = m = r = 0
    while True:
        stream, now = next_sample(acc_time_s, a, gyr_time_s, g, mag_time_s, m, rot_time_s, r)
        if now == math.inf:
            break
        if stream == GYR:
            interval_s = now - time_s[GYR]
            if s[STARTED] > 0.0 and interval_s <= STALE_S:
                for k in range(3):
                    work[k] = 0.5 * (rate[k] + gyr[g, k]) * interval_s
                predict(q, covariance, work, noise[0] * interval_s)
                rotate(q, work, work)
                s[TURN] -= work[2]
            rate[:] = gyr[g]
            time_s[GYR], g = now, g + 1
        elif stream == MAG:
            if s[STARTED] > 0.0:
                interval_s = min(max(now - time_s[MAG], LEAST_INTERVAL_S), LARGEST_INTERVAL_S)
                _see_field(mag[m], interval_s, noise, q, covariance, s)
            time_s[MAG], m = now, m + 1
        elif stream == ROT:
            if s[STARTED] > 0.0 and now - time_s[MAG] > STALE_S:
                interval_s = min(max(now - time_s[ROT], LEAST_INTERVAL_S), LARGEST_INTERVAL_S)
                of_rotation_vector(rot[r], given)
                seen_by_device(given, north, work)
                _face(work, 0.0, noise[4] / interval_s, q, covariance, s)
            time_s[ROT], r = now, r + 1
        else:
            if now - time_s[ACC] > GAP_S:
                # nothing is known of the turns in a gap: begin again
                level(acc[a], q)
                start = np.diag(np.array([START_TILT_RAD**2, START_TILT_RAD**2, START_AZIMUTH_RAD**2]))
                covariance[:] = turn_covariance(q, start)
                s[STARTED], s[SEEKS_NORTH], s[ABSOLUTE], s[IN_CELL] = s[STARTED] + 1.0, 1.0, 0.0, 0.0
                sums[:] = 0.0
            elif now - time_s[GYR] > STALE_S:
                work[:] = 0.0
                predict(q, covariance, work, noise[1] * (now - time_s[ACC]))
            interval_s = min(max(now - time_s[ACC], LEAST_INTERVAL_S), LARGEST_INTERVAL_S)
            _feel(now, acc[a], interval_s, noise, q, covariance, s, sums, cells, poses)
            if now - time_s[GYR] > STALE_S:
                s[TURN] += wrap(azimuth(q) - s[POINTED])
            s[POINTED] = azimuth(q)
            uncertain = 4.0 * (covariance[0, 0] + covariance[1, 1] + covariance[2, 2] + covariance[3, 3])
            if uncertain > LARGEST_RAD2:
                covariance *= LARGEST_RAD2 / uncertain
            time_s[ACC], a = now, a + 1
