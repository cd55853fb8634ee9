"""The unscented filter against filterpy's, against the Kalman filter, on circles and without variance."""

from __future__ import annotations

import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from app.estimation import extended_kalman
from app.estimation import unscented_kalman as ukf
from app.estimation.arrays import FloatArray
from tests.estimation.walking_model import STATE_ANGLES, moved, observed, ukf_step

Q = np.diag([0.04, 0.05, 0.01])
R = np.diag([9.0, 7.0, 0.04, 0.01, 0.3])
LINEAR = np.zeros(3, np.bool_)


def random_covariance(rng: np.random.Generator, size: int, rank: int | None = None) -> FloatArray:
    root = rng.normal(size=(size, rank or size + 1))
    return np.asarray(root @ root.T)


@pytest.mark.parametrize("alpha", [1e-3, 0.1, 1.0])
def test_thirty_steps_equal_filterpys(alpha: float) -> None:
    rng = np.random.default_rng(1)
    before = np.array([10.0, 20.0, 0.3])
    other = UnscentedKalmanFilter(
        3, 5, 1.0, hx=observed, fx=lambda s, dt, length_m, turn_rad: moved(s, length_m, turn_rad),
        points=MerweScaledSigmaPoints(3, alpha, 2.0, 0.0),
    )  # fmt: skip
    other.x, other.P, other.Q, other.R = before.copy(), np.diag([4.0, 3.0, 0.1]), Q, R
    mean, covariance = other.x.copy(), other.P.copy()
    # filterpy adds up its weighted points as they are, and with alpha 1e-3 the weights are a million
    tolerance = 1e-9 if alpha > 1e-2 else 1e-7
    for _ in range(30):
        control = rng.normal(0.7, 0.05), rng.normal(0.0, 0.05)
        truth = moved(mean, *control)
        measured = observed(truth, mean) + rng.normal(size=5) * np.sqrt(np.diag(R)) * [1.0, 1.0, 1.0, 1.0, 0.2]
        at = mean
        mean, covariance = ukf_step(mean, covariance, control, measured, Q, R, alpha)
        other.predict(length_m=control[0], turn_rad=control[1])
        other.update(measured, before=at)
        assert mean == pytest.approx(other.x, abs=tolerance)
        assert covariance == pytest.approx(other.P, abs=tolerance)
        other.x, other.P = mean.copy(), covariance.copy()


@pytest.mark.parametrize("alpha", [1e-2, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_linear_problem_has_the_kalman_filters_answer(alpha: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    transition, jacobian = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    mean, covariance = rng.normal(size=3), random_covariance(rng, 3)
    q, r, measured = random_covariance(rng, 3), random_covariance(rng, 2), rng.normal(size=2)

    prior, p = transition @ mean, transition @ covariance @ transition.T + q
    s = jacobian @ p @ jacobian.T + r
    gain = p @ jacobian.T @ np.linalg.inv(s)
    expected_mean, expected_covariance = prior + gain @ (measured - jacobian @ prior), p - gain @ s @ gain.T

    wm, wc, spread = ukf.scaled_weights(3, alpha, 2.0, 0.0)
    points = ukf.sigma_points(mean, covariance, spread) @ transition.T
    prior_u, p_u = ukf.moments(points, wm, wc, q, LINEAR)
    points = ukf.sigma_points(prior_u, p_u, spread)
    seen = points @ jacobian.T
    z, s_u = ukf.moments(seen, wm, wc, r, LINEAR[:2])
    cross = ukf.cross_covariance(points, prior_u, LINEAR, seen, z, LINEAR[:2], wc)
    unscented = ukf.correct(prior_u, p_u, measured - z, s_u, cross, ukf.gain_of(cross, s_u), LINEAR)
    extended = extended_kalman.correct(
        prior, extended_kalman.predict_covariance(covariance, transition, q), measured - jacobian @ prior, jacobian, r
    )
    for found_mean, found_covariance in (unscented, extended):
        assert found_mean == pytest.approx(expected_mean, abs=1e-8)
        assert found_covariance == pytest.approx(expected_covariance, abs=1e-8)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.data())
def test_sigma_points_carry_the_covariance_they_were_drawn_from_also_a_singular_one(
    seed: int, size: int, data: st.DataObject
) -> None:
    rank = data.draw(st.integers(0, size))
    rng = np.random.default_rng(seed)
    covariance = random_covariance(rng, size, rank) if rank else np.zeros((size, size))
    mean = rng.normal(size=size)
    wm, wc, spread = ukf.scaled_weights(size, 0.5, 2.0, 0.0)
    points = ukf.sigma_points(mean, covariance, spread)
    found_mean, found = ukf.moments(points, wm, wc, np.zeros((size, size)), np.zeros(size, np.bool_))
    assert found_mean == pytest.approx(mean, abs=1e-9)
    assert found == pytest.approx(covariance, abs=1e-6 * max(1.0, float(np.trace(covariance))))


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.integers(-3, 3))
def test_a_step_does_not_depend_on_where_the_circle_is_cut(heading_rad: float, turns: int) -> None:
    covariance = np.diag([1.0, 2.0, 0.2])
    control, measured = (0.7, 0.2), np.array([1.0, -1.0, 0.72, 0.19, heading_rad + 0.3])
    mean = np.array([0.5, 0.2, heading_rad])
    shifted, elsewhere = mean.copy(), measured.copy()
    shifted[2] += 2.0 * np.pi * turns
    elsewhere[4] += 2.0 * np.pi * turns
    one = ukf_step(mean, covariance, control, measured, Q, R, 1.0)
    other = ukf_step(shifted, covariance, control, elsewhere, Q, R, 1.0)
    assert one[0] == pytest.approx(other[0], abs=1e-9)
    assert one[1] == pytest.approx(other[1], abs=1e-9)
    assert -np.pi < one[0][2] <= np.pi


def test_turning_the_whole_problem_across_the_seam_changes_only_the_heading() -> None:
    control, changes = (0.7, 0.1), []
    for start in (0.1, 3.0, -3.1):
        mean = np.array([0.0, 0.0, start])
        measured = observed(moved(mean, *control), mean)
        measured[4] += 0.2
        # observations that know nothing of the frame: only the three of step and heading
        r = np.diag([1e9, 1e9, 0.04, 0.01, 0.3])
        after, covariance = ukf_step(mean, np.diag([0.0, 0.0, 0.2]), control, measured, Q, r, 1.0)
        changes.append([(after[2] - start + np.pi) % (2.0 * np.pi) - np.pi, covariance[2, 2]])
    assert changes[1] == pytest.approx(changes[0], abs=1e-3)
    assert changes[2] == pytest.approx(changes[0], abs=1e-3)
    assert 0.1 < changes[0][0] < 0.3


def test_a_shrunk_gain_leaves_a_covariance_between_prior_and_posterior() -> None:
    rng = np.random.default_rng(3)
    p, jacobian, r = random_covariance(rng, 3), rng.normal(size=(2, 3)), random_covariance(rng, 2)
    cross, s = p @ jacobian.T, jacobian @ p @ jacobian.T + r
    gain = ukf.gain_of(cross, s)
    mean, innovation = np.zeros(3), np.ones(2)
    _, best = ukf.correct(mean, p, innovation, s, cross, gain, LINEAR)
    _, half = ukf.correct(mean, p, innovation, s, cross, 0.5 * gain, LINEAR)
    assert np.all(np.linalg.eigvalsh(half - best) > -1e-9)
    assert np.all(np.linalg.eigvalsh(p - half) > -1e-9)


def test_a_consistent_filter_knows_the_size_of_its_errors() -> None:
    rng = np.random.default_rng(7)
    nees, nis = [], []
    noise, r = np.diag([0.01, 0.01, 0.002]), np.diag([4.0, 4.0, 0.05])
    picked = [0, 1, 2]
    wm, wc, spread = ukf.scaled_weights(3, 1.0, 2.0, 0.0)
    for _ in range(60):
        mean, covariance = np.zeros(3), np.diag([2.0, 2.0, 0.1])
        truth = rng.multivariate_normal(mean, covariance)
        for _ in range(25):
            control = 0.7, float(rng.normal(0.0, 0.1))
            truth = moved(truth, *control) + rng.multivariate_normal(np.zeros(3), noise)
            points = np.array([moved(point, *control) for point in ukf.sigma_points(mean, covariance, spread)])
            mean, covariance = ukf.moments(points, wm, wc, noise, STATE_ANGLES)
            points = ukf.sigma_points(mean, covariance, spread)
            expected, s = ukf.moments(points[:, picked], wm, wc, r, STATE_ANGLES)
            innovation = truth + rng.multivariate_normal(np.zeros(3), r) - expected
            innovation[2] = (innovation[2] + np.pi) % (2.0 * np.pi) - np.pi
            cross = ukf.cross_covariance(points, mean, STATE_ANGLES, points[:, picked], expected, STATE_ANGLES, wc)
            nis.append(innovation @ np.linalg.solve(s, innovation))
            gain = ukf.gain_of(cross, s)
            mean, covariance = ukf.correct(mean, covariance, innovation, s, cross, gain, STATE_ANGLES)
        error = truth - mean
        error[2] = (error[2] + np.pi) % (2.0 * np.pi) - np.pi
        nees.append(error @ np.linalg.solve(covariance, error))
    # 95 % of the mean of 60 chi-squared values of 3 degrees of freedom, and of 1500
    assert 2.41 < np.mean(nees) < 3.65
    assert 2.88 < np.mean(nis) < 3.13
