"""The first filter of method C: the phone's attitude as a quaternion, by the unscented transform.

Yu, Na, Liu and Deng, EURASIP J. Wireless Communications and Networking 2019:41, section 5.2, its equations 7 to 18 (the
images are lost; this is our reading: docs/methods/dual_ukf.md). State: the quaternion (w, x, y, z) from the device to
east-north-up. The gyroscope moves it linearly, q <- exp(0.5 Ts Omega(w)) q, so that its mean and covariance need no
sigma points; what accelerometer and magnetometer should show, R(q)' g0 and R(q)' h0, is not linear and gets them.

Differs from the paper: the sensors of a phone do not tick together, so each is an observation of its own at its own
time; noises are densities over time, so that the phone's rate does not matter; sigma points are normalised before they
are turned into what a sensor shows, since only a unit quaternion is a rotation; h0 is what the site shows on average,
not a table's value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from app.estimation.arrays import FloatArray
from app.estimation.unscented_kalman import (
    correct,
    cross_covariance,
    gain_of,
    moments,
    scaled_weights,
    sigma_points,
)
from app.pdr.quaternion import multiply, rotate

ALPHA, BETA, KAPPA = 1.0, 2.0, 0.0
"""With alpha of 1 and four components no weight is negative, which a covariance without its fourth rank needs."""


@dataclass(frozen=True, slots=True)
class QuaternionNoise:
    """Of the sensors, as densities: a variance for samples a second apart. Chosen on folds 1-4 of the mall walks.

    gyroscope : rad^2/s, rate noise and all that a calibrated gyroscope still drifts.
    no_gyroscope : rad^2/s, how fast an unseen turn may be.
    accelerometer : (m/s^2)^2 s, of a phone at rest.  force_mps2 : by how much the norm must depart from gravity to
    double it.
    magnetometer : rad^2 s, of the field's direction where it is undisturbed.  norm_share, dip_rad : departures of
    the field's strength and dip from the site's mean that double it.
    """

    gyroscope: float = 1.0e-3
    no_gyroscope: float = 0.25
    accelerometer: float = 0.9
    force_mps2: float = 2.0
    magnetometer: float = 0.1
    norm_share: float = 0.1
    dip_rad: float = 0.17

    def values(self) -> FloatArray:
        """The same as an array (7,), in that order, for compiled code."""
        return np.array(
            [
                self.gyroscope,
                self.no_gyroscope,
                self.accelerometer,
                self.force_mps2,
                self.magnetometer,
                self.norm_share,
                self.dip_rad,
            ]
        )


@njit(cache=True)
def predict(q: FloatArray, covariance: FloatArray, turned_rad: FloatArray, variance: float) -> None:
    """Turn the state by the rotation vector (3,) that the gyroscope saw, in the device frame; in place.

    Parameters
    ----------
    q, covariance : (4,), (4, 4).  variance : of the rotation about each axis, rad^2.

    Notes
    -----
    Eq. 8-9. A noise of the same size about all axes moves q by (I - q q') variance / 4: never along itself.
    """
    x, y, z = turned_rad[0], turned_rad[1], turned_rad[2]
    angle = math.sqrt(x * x + y * y + z * z)
    c = math.cos(0.5 * angle)
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    x, y, z = s * x, s * y, s * z
    transition = np.array([[c, -x, -y, -z], [x, c, z, -y], [y, -z, c, x], [z, y, -x, c]])
    q[:] = transition @ q
    q /= math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    covariance[:] = transition @ covariance @ transition.T
    for i in range(4):
        for j in range(4):
            covariance[i, j] += 0.25 * variance * ((1.0 if i == j else 0.0) - q[i] * q[j])


@njit(cache=True)
def seen_by_device(q: FloatArray, reference: FloatArray, seen: FloatArray) -> None:
    """What a device of attitude q (4,), of any norm but 0, sees of a vector (3,) of the frame: R(q)' v."""
    norm2 = q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2
    w, x, y, z = q[0], -q[1], -q[2], -q[3]
    a, b, c = reference[0], reference[1], reference[2]
    p, r, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    seen[0] = a + (w * p + y * s - z * r) / norm2
    seen[1] = b + (w * r + z * p - x * s) / norm2
    seen[2] = c + (w * s + x * r - y * p) / norm2


@njit(cache=True)
def update(q: FloatArray, covariance: FloatArray, measured: FloatArray, reference: FloatArray, variance: float) -> None:
    """Correct the state in place by a vector (3,) that the device sees of a known one (3,) of the frame, Eq. 11-18.

    variance : of each component of what is measured, in its unit squared.
    """
    mean_weight, covariance_weight, spread = scaled_weights(4, ALPHA, BETA, KAPPA)
    points = sigma_points(q, covariance, spread)
    seen = np.empty((9, 3))
    for i in range(9):
        seen_by_device(points[i], reference, seen[i])
    no_angles, no_state_angles = np.zeros(3, np.bool_), np.zeros(4, np.bool_)
    expected, innovation_covariance = moments(seen, mean_weight, covariance_weight, variance * np.eye(3), no_angles)
    cross = cross_covariance(points, q, no_state_angles, seen, expected, no_angles, covariance_weight)
    gain = gain_of(cross, innovation_covariance)
    after, covariance_after = correct(
        q, covariance, measured - expected, innovation_covariance, cross, gain, no_state_angles
    )
    q[:] = after / math.sqrt(after[0] ** 2 + after[1] ** 2 + after[2] ** 2 + after[3] ** 2)
    covariance[:] = covariance_after


@njit(cache=True)
def turn_covariance(q: FloatArray, turn: FloatArray) -> FloatArray:
    """(4, 4) covariance of q for a covariance `turn` (3, 3) of small rotations in east-north-up, rad^2."""
    effect = np.empty((4, 3))
    basis = np.zeros(4)
    for axis in range(3):
        basis[:] = 0.0
        basis[1 + axis] = 1.0
        column = np.empty(4)
        multiply(basis, q, column)
        for i in range(4):
            effect[i, axis] = 0.5 * column[i]
    return effect @ turn @ effect.T


@njit(cache=True)
def turn_of(q: FloatArray, covariance: FloatArray) -> FloatArray:
    """(3, 3) covariance of small rotations in east-north-up (rad^2) that a covariance (4, 4) of q (4,) amounts to."""
    conjugate = np.array([q[0], -q[1], -q[2], -q[3]])
    effect, basis, column = np.empty((3, 4)), np.zeros(4), np.empty(4)
    for i in range(4):
        basis[:] = 0.0
        basis[i] = 1.0
        multiply(basis, conjugate, column)
        for axis in range(3):
            effect[axis, i] = 2.0 * column[1 + axis]
    return effect @ covariance @ effect.T


@njit(cache=True)
def level(force: FloatArray, q: FloatArray) -> None:
    """Set q (4,) to the attitude that has gravity where the accelerometer (3,) shows it; its azimuth means nothing."""
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size < 1.0:  # free fall or a dead sensor
        q[0], q[1], q[2], q[3] = 1.0, 0.0, 0.0, 0.0
        return
    x, y, z = force[0] / size, force[1] / size, force[2] / size
    w = math.sqrt(max(0.5 * (1.0 + z), 0.0))
    if w > 1e-6:
        q[0], q[1], q[2], q[3] = w, y / (2.0 * w), -x / (2.0 * w), 0.0
    else:  # face down
        q[0], q[1], q[2], q[3] = 0.0, 1.0, 0.0, 0.0


@njit(cache=True)
def face_north(field: FloatArray, q: FloatArray) -> None:
    """Turn q (4,) about the vertical until the field (3,) that the device sees points north; in place."""
    seen, turn = np.empty(3), np.zeros(4)
    rotate(q, field, seen)
    bearing = math.atan2(seen[0], seen[1])
    turn[0], turn[3] = math.cos(0.5 * bearing), math.sin(0.5 * bearing)
    multiply(turn, q, q)
