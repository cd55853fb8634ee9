from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

from app.evaluation.consistency import DIMENSION, consistency, nees
from tests.evaluation.answers import answer


def test_nees_is_the_squared_error_in_units_of_the_covariance() -> None:
    covariance = np.array([[[4.0, 1.0], [1.0, 9.0]]])
    error = np.array([[2.0, -3.0]])
    assert nees(error, covariance)[0] == pytest.approx(float(error[0] @ np.linalg.inv(covariance[0]) @ error[0]))


def test_consistent_errors_have_a_mean_nees_within_the_interval_and_halved_covariances_not() -> None:
    rng = np.random.default_rng(7)
    roots = rng.normal(size=(4000, 2, 2)) + 2 * np.eye(2)
    covariance = roots @ roots.transpose(0, 2, 1)
    error = np.einsum("nij,nj->ni", roots, rng.normal(size=(4000, 2)))
    low, high = (chi2.ppf((0.025, 0.975), 4000 * DIMENSION) / 4000).tolist()
    assert low < 2.0 < high
    assert low <= nees(error, covariance).mean() <= high
    assert nees(error, covariance / 2).mean() > high


def test_an_error_without_any_claimed_variance_is_infinitely_inconsistent() -> None:
    assert nees(np.array([[1.0, 0.0]]), np.zeros((1, 2, 2)))[0] == math.inf


def test_the_ellipse_share_and_the_correlation_are_of_the_answers() -> None:
    # sigma 2 m: errors of 2, 2, 2 and 10 m have NEES 1, 1, 1 and 25; the walk ends before the fourth
    result = consistency([answer(2.0), answer(2.0), answer(2.0), answer(10.0, walk="two")])
    assert result.n == 4
    assert result.nees_mean == pytest.approx(7.0)
    assert result.nees_median == pytest.approx(1.0)
    assert result.inside_95_ellipse == 0.75
    assert result.lag1_correlation == pytest.approx(1.0)


def test_positions_on_a_wrong_floor_are_not_judged() -> None:
    assert consistency([answer(50.0, floor_right=False), answer(None)]).n == 0
