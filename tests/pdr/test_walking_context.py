"""What a walker does is told from the last few steps, and from nothing older."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.observations import Step
from app.pdr.walking_context import LONGEST_STEP_S, WINDOW, Pace, WalkingContext, context_after


def step(turn_rad: float = 0.0, length_m: float = 0.65, duration_s: float = 0.54) -> Step:
    return Step(0.0, duration_s, length_m, 0.0, 0.1, turn_rad, math.nan)


def after(*steps: Step) -> WalkingContext:
    context = WalkingContext()
    for one in steps:
        context = context_after(context, one)
    return context


def test_nobody_who_has_not_walked_turns_or_hurries() -> None:
    assert not WalkingContext().turning
    assert WalkingContext().pace is Pace.NORMAL


def test_a_corner_is_a_turn_until_it_lies_a_window_behind() -> None:
    corner = [step(math.radians(30.0)), step(math.radians(30.0))]
    assert after(*corner).turning
    assert after(*corner, step()).turning
    assert not after(*corner, *[step()] * WINDOW).turning


def test_the_sway_of_the_hand_is_no_turn() -> None:
    sway = [step(math.radians(15.0) * (-1) ** k) for k in range(9)]
    assert not any(after(*sway[:count]).turning for count in range(1, 10))


@pytest.mark.parametrize(
    ("length_m", "duration_s", "pace"),
    [(0.45, 0.65, Pace.SLOW), (0.65, 0.54, Pace.NORMAL), (0.8, 0.45, Pace.FAST)],
)
def test_pace_is_the_speed_of_the_last_steps(length_m: float, duration_s: float, pace: Pace) -> None:
    assert after(*[step(length_m=length_m, duration_s=duration_s)] * WINDOW).pace is pace


def test_a_step_after_a_pause_begins_a_new_context() -> None:
    turned = after(step(1.0), step(1.0))
    paused = context_after(turned, step(duration_s=LONGEST_STEP_S + 5.0))
    assert turned.turning and not paused.turning
    assert len(paused.turns_rad) == 1


@given(st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(0.0, 2.0), st.floats(0.0, 10.0)), max_size=20))
def test_a_context_never_holds_more_than_its_window_and_left_is_as_good_as_right(
    walk: list[tuple[float, float, float]],
) -> None:
    one, other = (after(*[step(side * turn, length, time) for turn, length, time in walk]) for side in (1.0, -1.0))
    assert len(one.turns_rad) == len(one.speeds_mps) <= WINDOW
    assert (one.turning, one.pace) == (other.turning, other.pace)
