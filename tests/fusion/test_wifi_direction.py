"""Where a walker is going, from where he was."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.wifi_direction import FIXES, direction_of

FOUR = np.arange(4.0)[:, np.newaxis]


@given(heading=st.floats(-3.1, 3.1), step_m=st.floats(1.5, 20.0))
def test_a_straight_way_has_its_own_direction(heading: float, step_m: float) -> None:
    fixes = np.array([7.0, -3.0]) + FOUR * step_m * np.array([math.sin(heading), math.cos(heading)])
    found = direction_of(fixes, 4.0)
    assert found is not None
    assert math.remainder(found - heading, math.tau) == pytest.approx(0.0, abs=1e-6)


def test_errors_across_the_way_are_averaged() -> None:
    fixes = np.array([[0.0, 0.5], [3.0, -0.5], [6.0, -0.5], [9.0, 0.5]])
    assert direction_of(fixes, 4.0) == pytest.approx(math.pi / 2.0)


def test_the_way_back_is_the_opposite_direction() -> None:
    fixes = np.array([[0.0, 0.0], [0.2, 3.0], [-0.1, 6.0], [0.0, 9.0]])
    there, back = direction_of(fixes, 4.0), direction_of(fixes[::-1], 4.0)
    assert there is not None and back is not None
    assert abs(math.remainder(there - back, math.tau)) == pytest.approx(math.pi)


def test_three_fixes_are_too_few_and_standing_is_no_way() -> None:
    way = FOUR * np.array([3.0, 1.0])
    assert direction_of(way[:3], 4.0) is None
    assert len(way) == FIXES and direction_of(way, 4.0) is not None
    assert direction_of(np.array([[0.0, 0.0], [3.0, 1.0], [-2.0, 1.0], [0.5, 0.5]]), 4.0) is None
    assert direction_of(np.zeros((4, 2)), 0.1) is None
