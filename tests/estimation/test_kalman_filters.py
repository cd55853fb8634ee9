"""The extended and the error-state filter against each other, against differences, and at extreme noise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.estimation import error_state_kalman, extended_kalman
from app.estimation.arrays import FloatArray
from tests.estimation.walking_model import moved


def jacobian_of_step(heading_rad: float, length_m: float) -> FloatArray:
    """Of `moved` to the state, written from the formula."""
    f = np.eye(3)
    f[0, 2], f[1, 2] = length_m * np.cos(heading_rad), -length_m * np.sin(heading_rad)
    return f


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(0.1, 1.5))
def test_the_steps_jacobian_equals_differences(heading_rad: float, length_m: float) -> None:
    at = np.array([1.0, 2.0, heading_rad])
    found = np.empty((3, 3))
    for k in range(3):
        away = np.zeros(3)
        away[k] = 1e-6
        found[:, k] = (moved(at + away, length_m, 0.1) - moved(at - away, length_m, 0.1)) / 2e-6
    assert found == pytest.approx(jacobian_of_step(heading_rad, length_m), abs=1e-8)


def test_the_error_fed_back_equals_the_extended_filters_correction() -> None:
    rng = np.random.default_rng(2)
    root, h = rng.normal(size=(4, 4)), rng.normal(size=(2, 4))
    covariance, noise, innovation = root @ root.T, np.diag([0.5, 2.0]), rng.normal(size=2)
    nominal = rng.normal(size=4)
    error, after = error_state_kalman.error_after(covariance, innovation, h, noise)
    mean, expected = extended_kalman.correct(nominal, covariance, innovation, h, noise)
    assert nominal + error == pytest.approx(mean)
    assert after == pytest.approx(expected)


def test_an_observation_of_endless_noise_changes_nothing() -> None:
    mean, covariance = np.array([1.0, 2.0]), np.diag([3.0, 4.0])
    after, spread = extended_kalman.correct(
        mean, covariance, np.array([50.0]), np.array([[1.0, 1.0]]), np.array([[1e30]])
    )
    assert after == pytest.approx(mean)
    assert spread == pytest.approx(covariance)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_covariance_stays_symmetric_and_never_negative(seed: int) -> None:
    rng = np.random.default_rng(seed)
    covariance = np.diag(10.0 ** rng.uniform(-6, 6, 3))
    for _ in range(20):
        transition = np.eye(3) + 0.1 * rng.normal(size=(3, 3))
        covariance = extended_kalman.predict_covariance(covariance, transition, 1e-3 * np.eye(3))
        h, noise = rng.normal(size=(1, 3)), np.array([[10.0 ** rng.uniform(-8, 2)]])
        _, covariance = extended_kalman.correct(np.zeros(3), covariance, rng.normal(size=1), h, noise)
        assert np.array_equal(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance).min() > -1e-9 * np.trace(covariance)
