"""Step lengths grow with the swing of the acceleration, and stay lengths that legs can have."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.pdr.step_length import TRAINED_PERIOD_S, linear_length_m, swing_of_mps2, weinberg_length_m


@given(st.floats(0.0, 1e3), st.floats(0.2, 1.0))
def test_the_swing_is_found_again_from_the_length(swing_mps2: float, k: float) -> None:
    assert swing_of_mps2(weinberg_length_m(swing_mps2, k), k) == pytest.approx(swing_mps2, abs=1e-9)


def test_weinbergs_length_grows_with_the_fourth_root_of_the_swing() -> None:
    assert weinberg_length_m(16.0, k=0.57) == pytest.approx(1.14)
    assert weinberg_length_m(-1.0) == 0.0


@given(st.floats(0.0, 10.0), st.floats(0.0, 1e3))
def test_a_linear_length_is_one_that_legs_can_have_whatever_comes_in(period_s: float, swing_mps2: float) -> None:
    assert 0.4 < linear_length_m(period_s, swing_mps2) < 1.1


def test_the_usual_step_of_a_mall_walker_has_the_usual_length() -> None:
    """Median period and swing of the walks that the regression saw, and their mean step."""
    assert linear_length_m(0.5425, 9.17) == pytest.approx(0.706, abs=0.02)


def test_beyond_the_periods_that_were_seen_the_line_does_not_go_on() -> None:
    shortest_s, longest_s = TRAINED_PERIOD_S
    assert linear_length_m(longest_s + 1.0, 9.0) == linear_length_m(longest_s, 9.0)
    assert linear_length_m(shortest_s / 2.0, 9.0) == linear_length_m(shortest_s, 9.0)
    assert linear_length_m(0.55, 9.0) > linear_length_m(0.5, 9.0)
    assert linear_length_m(0.55, 12.0) > linear_length_m(0.55, 9.0)
