"""The attitude filter of method C: against rotations, against another filter, by its consistency, and on recordings."""

from __future__ import annotations

import math

import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.pdr.carried_motion import carry
from app.pdr.carried_state import CarriedMotion
from app.pdr.gravity import GRAVITY_MPS2
from app.pdr.quaternion_ukf import (
    QuaternionNoise,
    face_north,
    level,
    predict,
    seen_by_device,
    turn_covariance,
    turn_of,
    update,
)
from tests.open_data import open_data
from tests.pdr.test_attitude import TRIALS, heading_rmse_deg

UP = np.array([0.0, 0.0, GRAVITY_MPS2])
FIELD = np.array([0.0, 0.6, -0.8])
numbers = st.floats(-1.0, 1.0)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
quaternions = (
    st.tuples(numbers, numbers, numbers, numbers)
    .map(np.array)
    .filter(lambda q: bool(np.linalg.norm(q) > 0.1))
    .map(lambda q: q / np.linalg.norm(q))
)


def rotation(q: FloatArray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1))


def same(one: FloatArray, other: FloatArray) -> bool:
    return bool(min(np.abs(one - other).max(), np.abs(one + other).max()) < 1e-9)


@settings(deadline=None)
@given(quaternions, vectors)
def test_the_gyroscope_turns_the_attitude_exactly(q: FloatArray, turned_rad: FloatArray) -> None:
    after, covariance = q.copy(), np.zeros((4, 4))
    predict(after, covariance, turned_rad, 0.01)
    expected = (rotation(q) * Rotation.from_rotvec(turned_rad)).as_quat()
    assert same(after, np.roll(expected, 1))
    assert np.abs(turn_of(after, covariance) - 0.01 * np.eye(3)).max() < 1e-12


@settings(deadline=None)
@given(quaternions, vectors, st.floats(0.1, 3.0))
def test_what_a_device_sees_does_not_depend_on_the_norm_of_the_quaternion(
    q: FloatArray, vector: FloatArray, norm: float
) -> None:
    seen = np.empty(3)
    seen_by_device(norm * q, vector, seen)
    assert np.abs(seen - rotation(q).inv().apply(vector)).max() < 1e-12


@settings(deadline=None)
@given(quaternions, vectors)
def test_covariances_of_turns_and_of_quaternions_are_two_forms_of_one(q: FloatArray, sigmas: FloatArray) -> None:
    turn = np.diag(sigmas**2)
    covariance = turn_covariance(q, turn)
    assert np.abs(turn_of(q, covariance) - turn).max() < 1e-12
    assert np.abs(covariance @ q).max() < 1e-12  # none along the quaternion itself


@settings(deadline=None)
@given(quaternions, vectors, vectors, st.floats(1e-4, 10.0))
def test_a_singular_covariance_stays_one_and_the_quaternion_a_unit_whatever_is_measured(
    q: FloatArray, sigmas: FloatArray, measured: FloatArray, variance: float
) -> None:
    covariance = turn_covariance(q, np.diag(np.round(sigmas, 1) ** 2))  # often without any variance about an axis
    before = np.trace(covariance)
    update(q, covariance, measured, FIELD, variance)
    assert np.linalg.norm(q) == pytest.approx(1.0)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    assert np.trace(covariance) <= before + 1e-9


def test_an_update_is_that_of_another_unscented_filter() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        root = 0.05 * rng.normal(size=(4, 4))
        covariance = root @ root.T + 1e-4 * np.eye(4)
        measured = rotation(q).inv().apply(UP) + rng.normal(0.0, 0.3, 3)

        def seen(state: FloatArray) -> FloatArray:
            return np.asarray(rotation(state / np.linalg.norm(state)).inv().apply(UP))

        points = MerweScaledSigmaPoints(4, alpha=1.0, beta=2.0, kappa=0.0)
        other = UnscentedKalmanFilter(4, 3, 1.0, seen, lambda state, _: state, points)
        other.x, other.P, other.Q, other.R = q.copy(), covariance.copy(), np.zeros((4, 4)), 0.09 * np.eye(3)
        other.predict()
        other.update(measured)
        ours, spread = q.copy(), covariance.copy()
        update(ours, spread, measured, UP, 0.09)
        assert ours == pytest.approx(other.x / np.linalg.norm(other.x), abs=1e-8)
        assert spread == pytest.approx(other.P, abs=1e-8)


@settings(deadline=None)
@given(vectors.filter(lambda v: bool(np.linalg.norm(v) > 0.2)), vectors.filter(lambda v: bool(np.linalg.norm(v) > 0.2)))
def test_it_begins_level_and_facing_north(force: FloatArray, field: FloatArray) -> None:
    force = 10.0 * force / np.linalg.norm(force)
    q = np.empty(4)
    level(force, q)
    assert np.abs(rotation(q).apply(force) - [0.0, 0.0, 10.0]).max() < 1e-4
    face_north(field, q)
    east, north, _ = rotation(q).apply(field)
    assert abs(east) < 1e-6 and north > -1e-6
    assert np.abs(rotation(q).apply(force) - [0.0, 0.0, 10.0]).max() < 1e-4


def test_gravity_tells_nothing_of_the_azimuth() -> None:
    q = np.array([1.0, 0.0, 0.0, 0.0])
    covariance = turn_covariance(q, 0.04 * np.eye(3))
    for _ in range(50):
        update(q, covariance, UP, UP, 0.5)
    turn = turn_of(q, covariance)
    assert turn[2, 2] == pytest.approx(0.04, rel=0.01)
    assert max(turn[0, 0], turn[1, 1]) < 1e-3


def test_the_covariance_is_honest_over_seeded_runs() -> None:
    rate_hz, rate_sigma, force_sigma, field_sigma = 50.0, 0.1, 0.5, 0.05
    squares = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        truth = Rotation.random(rng=rng)
        start = Rotation.from_rotvec(rng.normal(0.0, 0.2, 3))
        q = np.roll((start * truth).as_quat(), 1)
        covariance = turn_covariance(q, 0.04 * np.eye(3))
        for k in range(200):
            rate = np.array([math.sin(0.03 * k), 0.5, math.cos(0.02 * k)])
            truth = truth * Rotation.from_rotvec(rate / rate_hz)
            predict(q, covariance, (rate + rng.normal(0.0, rate_sigma, 3)) / rate_hz, (rate_sigma / rate_hz) ** 2)
            update(q, covariance, truth.inv().apply(UP) + rng.normal(0.0, force_sigma, 3), UP, force_sigma**2)
            update(q, covariance, truth.inv().apply(FIELD) + rng.normal(0.0, field_sigma, 3), FIELD, field_sigma**2)
        error = (rotation(q) * truth.inv()).as_rotvec()
        squares.append(error @ np.linalg.solve(turn_of(q, covariance), error))
    assert 2.0 < np.mean(squares) < 4.0  # of three degrees of freedom: 3, and 0.45 its standard deviation


def attitudes(time_s: FloatArray, force: FloatArray, rate: FloatArray, field: FloatArray) -> Rotation:
    """After each sample; all sensors sampled together."""
    arrays, noise = CarriedMotion().arrays(), QuaternionNoise().values()
    none, nothing = np.empty(0), np.empty((0, 3))
    found = np.empty((len(time_s), 4))
    for i in range(len(time_s)):
        at = slice(i, i + 1)
        carry(arrays, noise, time_s[at], force[at], time_s[at], rate[at], time_s[at], field[at], none, nothing)
        found[i] = arrays[2]
    return Rotation.from_quat(np.roll(found, -1, axis=1))


@pytest.mark.parametrize(("trial", "limit_deg"), list(zip(TRIALS, (4.0, 2.0, 11.5), strict=True)))
def test_the_heading_follows_optical_truth(trial: str, limit_deg: float) -> None:
    recording = loadmat(open_data("broad", f"{trial}.mat"))
    force, rate, field = (np.ascontiguousarray(recording[name]) for name in ("imu_acc", "imu_gyr", "imu_mag"))
    found = attitudes(np.arange(len(force)) / float(recording["sampling_rate"][0, 0]), force, rate, field)
    assert heading_rmse_deg(found, recording["opt_quat"], recording["movement"].ravel()) < limit_deg
