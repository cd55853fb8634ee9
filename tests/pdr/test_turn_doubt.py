"""A gyroscope is doubted when it and the compass drift apart steadily, and not when the compass is merely wrong; in
its stead the compass leads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.observations import Step
from app.pdr.turn_doubt import COMPASS_SIGMA_RAD, MOST_STEPS, SPAN_S, LedStep, TurnRecord, led, noted, turns_doubted

PERIOD_S = 0.55


def steps(seconds: float, bias_rad_per_s: float, noise_rad: float, seed: int, compass: bool = True) -> list[Step]:
    """Round bends, by a gyroscope with this bias and a compass with this noise."""
    rng = np.random.default_rng(seed)
    found, heading_rad = list[Step](), 0.0
    for at_s in np.arange(0.0, seconds, PERIOD_S):
        turn_rad = float(rng.choice([0.0, 0.0, 0.0, 0.8, -0.8]))
        heading_rad += turn_rad
        seen_rad = heading_rad + float(rng.normal(0.0, noise_rad))
        bearing_rad = math.remainder(seen_rad, math.tau) if compass else math.nan
        change_rad = turn_rad + bias_rad_per_s * PERIOD_S
        found.append(Step(float(at_s), PERIOD_S, 0.7, heading_rad, 0.2, change_rad, bearing_rad))
    return found


def walk(seconds: float, bias_rad_per_s: float, noise_rad: float, seed: int, compass: bool = True) -> TurnRecord:
    """The record of these steps."""
    record = TurnRecord()
    for step in steps(seconds, bias_rad_per_s, noise_rad, seed, compass):
        record = noted(record, step)
    return record


@given(seed=st.integers(0, 10_000), bias=st.sampled_from([-0.25, 0.25]))
def test_a_steady_drift_is_noticed_within_the_span(seed: int, bias: float) -> None:
    assert turns_doubted(walk(SPAN_S + 1.0, bias, 0.2, seed))


@given(seed=st.integers(0, 10_000))
def test_a_noisy_compass_alone_raises_no_doubt(seed: int) -> None:
    assert not turns_doubted(walk(30.0, 0.0, 0.3, seed))


def test_a_few_steps_are_not_enough() -> None:
    assert not turns_doubted(TurnRecord())
    assert not turns_doubted(walk(6.0, 0.4, 0.05, 1))


def test_without_a_compass_nothing_can_be_doubted() -> None:
    record = walk(30.0, 0.4, 0.1, 1, compass=False)
    assert len(record.steps) == 0
    assert not turns_doubted(record)


def test_the_record_is_short_however_long_the_walk() -> None:
    record = walk(300.0, 0.0, 0.1, 1)
    assert len(record.steps) <= MOST_STEPS + 1
    assert record.steps[-1, 0] - record.steps[0, 0] <= SPAN_S + PERIOD_S


def test_the_compass_leads_while_the_gyroscope_is_doubted() -> None:
    walked = steps(40.0, 0.25, 0.0, 3)
    _, ledby = led(TurnRecord(), walked, turns=True)
    doubted = [not one.turns for one in ledby]
    begins = doubted.index(True)
    assert begins * PERIOD_S < SPAN_S
    assert all(doubted[begins:])
    assert [one.doubted for one in ledby] == doubted
    assert [one.afresh for one in ledby] == [k == begins for k in range(len(ledby))]
    assert [one.step for one in ledby[:begins]] == walked[:begins]
    for before, now, one in zip(walked[begins - 1 :], walked[begins:], ledby[begins:], strict=False):
        assert one.step.heading_rad == now.magnetic_heading_rad
        assert one.step.heading_sigma_rad == COMPASS_SIGMA_RAD
        turned_rad = math.remainder(now.magnetic_heading_rad - before.magnetic_heading_rad, math.tau)
        assert math.isclose(one.step.heading_change_rad, turned_rad, abs_tol=1e-9)


def test_where_the_compass_is_silent_a_doubted_gyroscope_leads_less_its_drift() -> None:
    bias = 0.25
    walked = steps(40.0, bias, 0.0, 3)
    silent = range(45, 50)
    heard = [replace(one, magnetic_heading_rad=math.nan) if k in silent else one for k, one in enumerate(walked)]
    _, ledby = led(TurnRecord(), heard, turns=True)
    for k in silent:
        assert ledby[k].doubted and ledby[k].turns and not ledby[k].step.absolute
        true_rad = walked[k].heading_change_rad - bias * PERIOD_S
        assert math.isclose(ledby[k].step.heading_change_rad, true_rad, abs_tol=0.02)
    turned = sum(one.step.heading_change_rad for one in ledby[45:51])
    true_turn_rad = sum(one.heading_change_rad - bias * PERIOD_S for one in walked[45:51])
    assert math.isclose(math.remainder(turned - true_turn_rad, math.tau), 0.0, abs_tol=0.05)
    assert not ledby[50].turns


def test_a_compass_that_has_been_silent_for_long_is_forgotten() -> None:
    walked = steps(60.0, 0.25, 0.0, 3)
    heard = [replace(one, magnetic_heading_rad=math.nan) if one.time_s > 25.0 else one for one in walked]
    record, ledby = led(TurnRecord(), heard, turns=True)
    assert not ledby[44].turns
    assert ledby[-1] == LedStep(heard[-1])
    assert len(record.steps) == 0


def test_a_gyroscope_that_is_right_leads_or_there_is_none() -> None:
    walked = steps(40.0, 0.0, 0.2, 3)
    for turns in (True, False):
        record, ledby = led(TurnRecord(), walked[:30], turns)
        _, after = led(record, walked[30:], turns)
        assert [*ledby, *after] == [LedStep(step, turns) for step in walked]
