"""The integrity paper's heading and step length."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.pdr.heading import combined_heading_rad
from app.pdr.step_length import weinberg_length_m

angles = st.floats(-math.pi, math.pi)


@given(st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.floats(-1.5, 1.5))
def test_away_from_the_wrap_it_is_the_printed_weighted_mean(previous: float, change: float, magnetic: float) -> None:
    expected = 0.99 * (previous + change) + 0.01 * magnetic
    assert combined_heading_rad(previous, change, magnetic) == pytest.approx(expected, abs=1e-12)


@given(angles, angles, angles)
def test_it_does_not_depend_on_where_the_circle_is_cut(previous: float, change: float, magnetic: float) -> None:
    here = combined_heading_rad(previous, change, magnetic)
    there = combined_heading_rad(previous + math.tau, change, magnetic)
    assert -math.pi < here <= math.pi
    opposite = abs(abs(math.remainder(magnetic - previous - change, math.tau)) - math.pi) < 1e-6
    assert opposite or abs(math.remainder(here - there, math.tau)) < 1e-9


def test_without_a_compass_the_gyroscope_decides_alone() -> None:
    assert combined_heading_rad(3.0, 0.5, math.nan) == pytest.approx(3.5 - math.tau)


def test_weinberg_grows_with_the_fourth_root_of_the_swing() -> None:
    assert weinberg_length_m(16.0, k=0.57) == pytest.approx(1.14)
    assert weinberg_length_m(-1.0) == 0.0
