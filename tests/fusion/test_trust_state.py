"""The trusted area, the mistrust and the three states."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.trust_chain_settings import TrustChainSettings
from app.fusion.trust_state import Trust, after_fix, after_way, state_after, weight_of, within_trusted_area

PAPER = TrustChainSettings()
LAST = np.array([10.0, 20.0])


def polar(distance_m: float, bearing_deg: float) -> list[float]:
    angle = math.radians(bearing_deg)
    return [10.0 + distance_m * math.sin(angle), 20.0 + distance_m * math.cos(angle)]


@pytest.mark.parametrize(
    ("distance_m", "bearing_deg", "trusted"),
    [
        (6.0, 90.0, True),
        (7.9, 134.0, True),
        (4.1, 46.0, True),
        (8.1, 90.0, False),
        (3.9, 90.0, False),
        (6.0, 136.0, False),
    ],
)
def test_the_area_is_two_metres_and_45_degrees_about_where_the_steps_lead(
    distance_m: float, bearing_deg: float, trusted: bool
) -> None:
    steps = np.array(polar(6.0, 90.0))
    assert within_trusted_area(np.array([polar(distance_m, bearing_deg)]), LAST, steps, PAPER).tolist() == [trusted]


def test_the_area_goes_on_across_south() -> None:
    steps = np.array(polar(6.0, 175.0))
    assert within_trusted_area(np.array([polar(6.0, -150.0)]), LAST, steps, PAPER)[0]


def test_who_has_not_moved_is_trusted_by_distance_alone() -> None:
    around = np.array([polar(1.9, bearing) for bearing in range(0, 360, 30)] + [polar(2.1, 0.0)])
    assert within_trusted_area(around, LAST, LAST, PAPER).tolist() == [True] * 12 + [False]


@given(angle=st.floats(0.0, 6.28), shift=st.floats(-50.0, 50.0))
def test_the_area_turns_and_moves_with_the_walker(angle: float, shift: float) -> None:
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    places = np.array([polar(d + 0.05, b + 0.5) for d in range(3, 9) for b in range(30, 150, 10)])
    steps = np.array(polar(6.0, 90.0))
    plain = within_trusted_area(places, LAST, steps, PAPER)
    moved = within_trusted_area(places @ turn.T + shift, turn @ LAST + shift, turn @ steps + shift, PAPER)
    assert np.array_equal(plain, moved)


def test_mistrust_grows_with_the_way_and_more_the_better_fixes_are() -> None:
    assert after_way(0.0, 10.0, PAPER) == pytest.approx(10.0 * 0.0897 / 0.75 / PAPER.fix_error_m)
    assert after_way(0.0, 10.0, TrustChainSettings(fix_error_m=2.68)) > after_way(0.0, 10.0, PAPER)


def test_a_trusted_fix_ends_all_mistrust() -> None:
    assert after_fix(3.7, True, PAPER) == 0.0


def test_mistrust_of_fix_after_fix_grows_rapidly_and_ends() -> None:
    mistrust, series = 0.5, []
    for _ in range(12):
        mistrust = after_fix(mistrust, False, PAPER)
        series.append(mistrust)
    assert series[:3] == pytest.approx([0.75, 1.3125, 3.03515625])
    assert series[-1] == PAPER.most_mistrust
    assert weight_of(series[-1]) > 0.99 and weight_of(1.0) == 0.5 and weight_of(0.0) == 0.0


def test_the_states_are_those_of_the_figure() -> None:
    for trust in Trust:
        for mistrust in (0.0, 0.5, 1.0, 9.0):
            assert state_after(trust, mistrust, True, PAPER) is Trust.TRUSTED_LOCKED
    assert state_after(Trust.TRUSTED_LOCKED, 0.2, False, PAPER) is Trust.LOCKED
    assert state_after(Trust.LOCKED, 0.9, False, PAPER) is Trust.LOCKED
    assert state_after(Trust.LOCKED, 1.0, False, PAPER) is Trust.UNLOCKED
    assert state_after(Trust.UNLOCKED, 0.1, False, PAPER) is Trust.UNLOCKED
