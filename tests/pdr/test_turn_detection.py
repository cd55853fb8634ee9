"""Turns are told from walking straight, step by step."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.observations import Step
from app.pdr.turn_detection import TURN_RAD, is_turn, last_turn_s, straight_since


def step(time_s: float, turn_rad: float) -> Step:
    return Step(time_s, 0.55, 0.65, 0.0, 0.2, turn_rad, math.nan)


def test_swaying_is_no_turn_and_a_corner_is_one_either_way() -> None:
    assert not is_turn(step(0.0, 0.15)) and not is_turn(step(0.0, -0.15))
    assert is_turn(step(0.0, 0.5)) and is_turn(step(0.0, -0.5))


@given(turns=st.lists(st.floats(-1.0, 1.0), max_size=8))
def test_the_newest_turn_is_remembered_however_the_steps_are_cut(turns: list[float]) -> None:
    steps = tuple(step(float(number), turn) for number, turn in enumerate(turns))
    expected = max([-math.inf, *(one.time_s for one in steps if abs(one.heading_change_rad) > TURN_RAD)])
    assert last_turn_s(-math.inf, steps) == expected
    cut = len(steps) // 2
    assert last_turn_s(last_turn_s(-math.inf, steps[:cut]), steps[cut:]) == expected


def test_a_way_is_straight_when_the_last_turn_came_before_it() -> None:
    assert straight_since(-math.inf, 3.0) and straight_since(2.9, 3.0)
    assert not straight_since(3.0, 3.0) and not straight_since(np.inf, 3.0)
