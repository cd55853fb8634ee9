"""Radii hold the share of a Gaussian that they promise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.integrity.protection_level import LEAST_RADIUS_M, protection_level_m, radius_holding

SAMPLES = np.random.default_rng(4).normal(size=(40_000, 2))


@settings(max_examples=40, deadline=None)
@given(st.floats(0.0, 1.0), st.floats(-0.99, 0.99), st.sampled_from([0.5, 0.68, 0.95, 0.99]))
def test_the_radius_holds_its_share(ratio: float, correlation: float, share: float) -> None:
    covariance = np.array([[9.0, 3.0 * ratio * correlation * 3.0], [9.0 * ratio * correlation, 9.0 * ratio**2]])
    values, vectors = np.linalg.eigh(covariance)
    drawn = SAMPLES * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
    held = float(np.mean(np.hypot(*drawn.T) <= radius_holding(covariance, share)))
    assert held == pytest.approx(share, abs=0.025)


def test_a_circle_and_a_line_are_exact() -> None:
    assert radius_holding(4.0 * np.eye(2), 0.68) == pytest.approx(2.0 * np.sqrt(-2.0 * np.log(0.32)))
    assert radius_holding(np.diag([4.0, 0.0]), 0.6827) == pytest.approx(2.0, abs=0.001)


@pytest.mark.parametrize("covariance", [np.zeros((2, 2)), np.full((2, 2), np.nan)])
def test_no_covariance_still_gives_a_positive_finite_radius(covariance: np.ndarray) -> None:
    assert radius_holding(covariance, 0.68) == LEAST_RADIUS_M


def test_the_level_grows_with_every_doubt() -> None:
    covariance = np.diag([4.0, 1.0])
    usual = protection_level_m(covariance, 0.01, 1.4)
    assert protection_level_m(covariance, 0.001, 1.4) > usual > protection_level_m(covariance, 0.05, 1.4)
    assert protection_level_m(covariance, 0.01, 2.0) > usual
    assert protection_level_m(4.0 * covariance, 0.01, 1.4) == pytest.approx(2.0 * usual)
    assert protection_level_m(covariance, 0.01, 1.4, 7.0) == pytest.approx(usual + 7.0)
