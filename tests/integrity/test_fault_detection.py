"""The three phases on innovations whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.estimation.unscented_kalman import gain_of
from app.integrity.fault_detection import Monitored, MonitorSettings, is_fault, monitored_update, streak_after

P, R = np.diag([4.0, 4.0, 1.0]), np.diag([5.0, 5.0])
H = np.eye(3)[:2]
OURS = MonitorSettings()


def monitored(innovation: FloatArray, monitor: MonitorSettings = OURS) -> Monitored:
    """An observation of the first two of three components; sigma of the innovation is 3 in each."""
    cross, spread = P @ H.T, H @ P @ H.T + R
    expectation = (innovation, spread, cross, gain_of(cross, spread))
    return monitored_update((np.zeros(3), P), expectation, R, np.zeros(3, np.bool_), monitor)


def kalman(innovation: FloatArray) -> FloatArray:
    return np.asarray(P @ H.T @ np.linalg.inv(H @ P @ H.T + R) @ innovation)


@settings(deadline=None)
@given(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0))
def test_below_the_threshold_the_answer_is_the_filters(x: float, y: float) -> None:
    found = monitored(np.array([x, y]))
    assert (found.if1, found.if2) == (0, 0)
    assert found.mean == pytest.approx(kalman(np.array([x, y])))
    assert found.statistic == pytest.approx((x * x + y * y) / 9.0)
    assert found.threshold == pytest.approx(29.83, abs=0.01)


def test_a_component_far_out_is_taken_out_and_the_other_kept() -> None:
    found = monitored(np.array([1.0, 60.0]))
    assert (found.if1, found.if2) == (1, 1)
    assert found.mean[0] == pytest.approx(kalman(np.array([1.0, 0.0]))[0], abs=1e-6)
    assert found.mean[1] == pytest.approx(0.0, abs=1e-6)
    assert found.covariance[1, 1] == pytest.approx(4.0)
    assert found.covariance[0, 0] < 4.0


def test_a_threshold_lower_than_the_component_test_lets_the_robust_update_suffice() -> None:
    found = monitored(np.array([8.0, 8.0]), MonitorSettings(false_alarm=0.01))
    assert (found.if1, found.if2) == (1, 0)
    assert np.all(found.mean[:2] < kalman(np.array([8.0, 8.0]))[:2])
    assert np.all(found.mean[:2] > 0.0)


def test_read_literally_nothing_ever_fails_the_third_phase() -> None:
    found = monitored(np.array([500.0, 500.0]), MonitorSettings(literal_phase3=True))
    assert (found.if1, found.if2) == (1, 0)
    assert found.mean == pytest.approx(0.0, abs=1e-6)


def test_unmonitored_everything_finite_is_fused() -> None:
    found = monitored(np.array([0.0, 60.0]), MonitorSettings(monitored=False))
    assert (found.if1, found.if2) == (0, 0)
    assert found.mean == pytest.approx(kalman(np.array([0.0, 60.0])))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("watched", [True, False])
def test_what_is_not_finite_is_rejected_and_changes_nothing(bad: float, watched: bool) -> None:
    found = monitored(np.array([0.0, bad]), MonitorSettings(monitored=watched))
    assert (found.if1, found.if2) == (1, 1)
    assert np.array_equal(found.mean, np.zeros(3))
    assert np.array_equal(found.covariance, P)


@settings(deadline=None)
@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_the_covariance_never_falls_below_the_optimal_nor_rises_above_the_prior(x: float, y: float) -> None:
    found = monitored(np.array([x, y]))
    best = P - P @ H.T @ np.linalg.inv(H @ P @ H.T + R) @ H @ P
    assert np.linalg.eigvalsh(found.covariance - best).min() > -1e-9
    assert np.linalg.eigvalsh(P - found.covariance).min() > -1e-9


def test_only_failures_in_a_row_are_a_fault() -> None:
    streaks = []
    streak = 0
    for if2 in (1, 1, 0, 1, 1, 1, 1, 0):
        streak = streak_after(streak, if2)
        streaks.append(is_fault(streak, OURS))
    assert streaks == [False, False, False, False, False, True, True, False]


def test_false_alarms_are_as_rare_as_asked_for() -> None:
    rng = np.random.default_rng(8)
    often = MonitorSettings(false_alarm=0.05)
    innovations = rng.normal(0.0, 3.0, (4000, 2))
    assert np.mean([monitored(r, often).if1 for r in innovations]) == pytest.approx(0.05, abs=0.011)
