"""Thresholds, robust weights and angles against their formulas and tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.stats import chi2

from app.estimation.angles import wrap, wrap_all
from app.estimation.innovation import chi2_threshold, f_threshold, normalised_square
from app.estimation.robust_weights import igg3, inflated

angles = st.floats(-1e4, 1e4)


@pytest.mark.parametrize(("size", "threshold"), [(5, 38.27), (4, 35.70), (3, 32.93), (2, 29.83)])
def test_thresholds_are_those_of_the_integrity_paper(size: int, threshold: float) -> None:
    assert chi2_threshold(size, 0.333e-6) == pytest.approx(threshold, abs=0.006)


def test_the_upper_one_percent_of_f_is_that_of_the_adaptive_robust_paper() -> None:
    assert f_threshold(2, 0.01) == pytest.approx(4.605, abs=0.001)


def test_the_statistic_of_gaussian_innovations_is_chi_squared() -> None:
    rng = np.random.default_rng(5)
    root = rng.normal(size=(3, 3))
    covariance = root @ root.T
    found = np.array([normalised_square(r, covariance) for r in rng.multivariate_normal(np.zeros(3), covariance, 4000)])
    assert np.mean(found) == pytest.approx(3.0, abs=0.12)
    assert np.mean(found > chi2.isf(0.05, 3)) == pytest.approx(0.05, abs=0.011)


@settings(deadline=None)
@given(st.floats(-50.0, 50.0))
def test_igg3_is_one_then_falls_then_lets_go(s: float) -> None:
    weight = igg3(np.array([s]))[0]
    size = abs(s)
    if size <= 2.5:
        assert weight == 1.0
    elif size < 3.5:
        assert weight == pytest.approx(max(2.5 / size * (3.5 - size) ** 2, 1e-30))
    else:
        assert weight == 1e-30


def test_igg3_never_rises_with_the_residual_and_lets_go_of_nan() -> None:
    weights = igg3(np.linspace(0.0, 6.0, 601))
    assert np.all(np.diff(weights) <= 0.0)
    assert igg3(np.array([math.nan]))[0] == 1e-30


@settings(deadline=None)
@given(arrays.arrays(np.float64, 3, elements=st.floats(1e-6, 1.0)))
def test_inflated_noise_is_the_papers_on_the_diagonal_and_stays_a_covariance(weights: np.ndarray) -> None:
    noise = np.array([[4.0, 1.0, 0.5], [1.0, 2.0, -0.3], [0.5, -0.3, 1.0]])
    after = inflated(noise, weights)
    assert np.diag(after) == pytest.approx(np.diag(noise) / weights)
    assert np.linalg.eigvalsh(after).min() > 0.0
    assert np.array_equal(after, after.T)


@settings(deadline=None)
@given(angles)
def test_a_wrapped_angle_points_the_same_way_and_lies_in_the_half_open_circle(angle_rad: float) -> None:
    wrapped = wrap(angle_rad)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped - angle_rad) == pytest.approx(1.0)
    assert math.cos(float(wrap_all(np.array([angle_rad]))[0]) - wrapped) == pytest.approx(1.0)


def test_minus_pi_is_pi() -> None:
    assert wrap(-math.pi) == math.pi
    assert wrap_all(np.array([-math.pi, math.pi])).tolist() == [math.pi, math.pi]
