"""How a phone is held is learnt from where its walker's way by steps lies beside the way by fixes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.facing import FacingRecord, FacingSettings, faced, placed
from app.observations import Step
from app.pdr.turn_doubt import LedStep

SETTINGS = FacingSettings()
STRIDES = 4
"""Between two fixes."""


def step(heading_rad: float = 0.0, heading_sigma_rad: float = 0.2, push_rad: float = math.nan) -> Step:
    return Step(0.0, 0.5, 0.7, heading_rad, heading_sigma_rad, 0.0, math.nan, push_rad)


def followed(
    held_rad: float,
    fixes: int,
    noise_m: float,
    seed: int,
    elsewhere_m: float = 0.0,
    believed: bool = True,
    pushed_rad: float = math.nan,
) -> tuple[FacingRecord, int | None]:
    """The record of a walk with a bend, by a phone that points this much to the left of it, and after how many fixes
    it was turned. elsewhere_m : by what the fixes leap in the middle.  pushed_rad : by steps, seen from the phone."""
    rng = np.random.default_rng(seed)
    record, at_m, turned_after = FacingRecord(), np.zeros(2), None
    for number in range(fixes):
        direction_rad = 0.3 if number < 6 else 1.2
        heading_rad, push_rad = math.remainder(direction_rad - held_rad, math.tau), pushed_rad + rng.normal(0.0, 0.5)
        told = [LedStep(step(heading_rad, push_rad=push_rad)) for _ in range(STRIDES)]
        record, steps = faced(record, told, SETTINGS)
        at_m += sum(one.step.length_m for one in steps) * np.array([math.sin(direction_rad), math.cos(direction_rad)])
        leap_m = elsewhere_m if number >= fixes // 2 else 0.0
        record, turned = placed(record, at_m + leap_m + rng.normal(0.0, noise_m, 2), 14.0, believed, SETTINGS)
        if turned and turned_after is None:
            turned_after = number + 1
    return record, turned_after


@given(seed=st.integers(0, 10_000), held_rad=st.sampled_from([-2.8, -1.6, 1.6, 2.8, math.pi]))
def test_a_phone_held_across_is_noticed_and_its_angle_learnt(seed: int, held_rad: float) -> None:
    record, after = followed(held_rad, 16, 2.0, seed)
    assert after is not None
    assert SETTINGS.least_fixes <= after <= 14
    assert abs(math.remainder(record.angle_rad - held_rad, math.tau)) < 0.9


@given(seed=st.integers(0, 10_000), held_rad=st.sampled_from([-1.57, 1.57, math.pi]), sway_rad=st.floats(-0.4, 0.4))
def test_pushes_tell_sooner_than_fixes_alone(seed: int, held_rad: float, sway_rad: float) -> None:
    record, after = followed(held_rad, 10, 2.0, seed, pushed_rad=held_rad + sway_rad)
    assert after is not None and after <= 8
    assert abs(math.remainder(record.angle_rad - held_rad, math.tau)) < 0.6


@given(seed=st.integers(0, 10_000))
def test_pushes_that_fixes_speak_against_turn_nothing(seed: int) -> None:
    assert followed(0.0, 12, 1.0, seed, pushed_rad=math.pi)[0].angle_rad == 0.0


@given(seed=st.integers(0, 10_000), held_rad=st.floats(-0.5, 0.5))
def test_a_compass_that_is_off_a_little_is_no_other_way_of_holding(seed: int, held_rad: float) -> None:
    record, after = followed(held_rad, 30, 3.0, seed)
    assert after is None
    assert record.angle_rad == 0.0
    assert len(record.ways) <= SETTINGS.fixes


@given(seed=st.integers(0, 10_000))
def test_a_way_that_leaps_is_nobodys(seed: int) -> None:
    assert followed(0.0, 12, 2.0, seed, elsewhere_m=40.0)[1] is None


def test_fixes_that_are_not_believed_turn_nothing() -> None:
    record, after = followed(math.pi, 20, 0.5, 1, believed=False)
    assert after is None
    assert len(record.ways) == 0


def test_steps_go_where_their_walker_goes() -> None:
    _, (one,) = faced(FacingRecord(angle_rad=2.0), [LedStep(step(heading_rad=2.0))], SETTINGS)
    assert one.step.heading_rad == pytest.approx(math.remainder(4.0, math.tau))


@pytest.mark.parametrize("one", [LedStep(step(heading_sigma_rad=math.pi)), LedStep(step(), afresh=True)])
def test_what_was_known_of_the_way_is_forgotten_where_directions_are_lost(one: LedStep) -> None:
    walked, _ = faced(FacingRecord(0.5), [LedStep(step())] * 3, SETTINGS)
    walked, _ = placed(walked, np.zeros(2), 14.0, True, SETTINGS)
    after, (found,) = faced(walked, [one], SETTINGS)
    assert len(after.ways) == 0
    assert after.angle_rad == 0.5
    assert isinstance(found.step, Step)
