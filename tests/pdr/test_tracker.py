"""Dead reckoning as the fusion sees it: batches of any cut, missing streams, gaps, and what is known at the end."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.observations import AxisSamples, Batch, Motion, Step
from app.pdr.tracker import PdrOutput, advance_pdr, initial_pdr_state
from tests.pdr.phones import START_S, STREAMS, Phone, inertial_batch, run, walked

WALK = walked(turn_rad_per_s=0.15, jitter=0.9, seconds=12.0, seed=4)
subsets = st.lists(st.sampled_from(STREAMS), min_size=1, max_size=4, unique=True)


def numbers(steps: tuple[Step, ...]) -> list[str]:
    return [repr(astuple(step)) for step in steps]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 16.0), max_size=40), subsets)
def test_how_a_walk_is_cut_into_batches_changes_nothing(cuts: list[float], streams: list[str]) -> None:
    whole = run(WALK.batch(*streams))[-1]
    parts = run(*WALK.batches([START_S + cut for cut in cuts], *streams))
    assert numbers(whole.steps) == numbers(tuple(step for output in parts for step in output.steps))
    assert repr(astuple(whole)[1:]) == repr(astuple(parts[-1])[1:])


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.0, 16.0), max_size=8))
def test_a_batch_may_be_taken_in_parts(stops: list[float]) -> None:
    batch = WALK.batch()
    state = initial_pdr_state()
    steps: list[Step] = []
    for stop in [*sorted(stops), None]:
        state, output = advance_pdr(state, batch, until_s=None if stop is None else START_S + stop)
        steps += output.steps
        assert stop is None or output.inertial_until_s is None or output.inertial_until_s <= START_S + stop
    assert numbers(tuple(steps)) == numbers(run(batch)[0].steps)


def test_advancing_does_not_touch_the_state_it_is_given() -> None:
    state, _ = advance_pdr(initial_pdr_state(), WALK.batches([START_S + 6.0])[0])
    before = repr(astuple(state))
    second = WALK.batches([START_S + 6.0])[1]
    once, again = advance_pdr(state, second), advance_pdr(state, second)
    assert repr(astuple(state)) == before
    assert repr(astuple(once[0])) == repr(astuple(again[0]))


def test_samples_seen_before_are_not_counted_again() -> None:
    first, second = run(WALK.batch(), WALK.batch())
    assert len(first.steps) > 15
    assert second.steps == ()


def finite(output: PdrOutput) -> bool:
    values = [output.pending_fraction]
    for step in output.steps:
        values += [step.time_s, step.duration_s, step.length_m, step.heading_rad, step.heading_sigma_rad]
        values += [step.heading_change_rad, 0.0 if math.isnan(step.magnetic_heading_rad) else step.magnetic_heading_rad]
    return all(math.isfinite(value) for value in values)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-9, 1.0, 30.0, 1e4]), subsets)
def test_nothing_that_is_not_finite_comes_of_finite_nonsense(seed: int, size: float, streams: list[str]) -> None:
    rng = np.random.default_rng(seed)
    batches = []
    for sequence in range(3):
        cut: dict[str, AxisSamples] = {}
        for name in streams:
            count = int(rng.integers(0, 300))
            time_s = (
                START_S + 10.0 * sequence + np.sort(np.round(rng.uniform(0.0, 10.0, count), int(rng.integers(0, 4))))
            )
            values = rng.normal(0.0, 0.6 if name == "rotation_vector" else size, (count, 3))
            cut[name] = AxisSamples(time_s, values * rng.integers(0, 2))
        batches.append(inertial_batch(sequence, cut))
    for output in run(*batches):
        assert finite(output)
        assert all(step.duration_s > 0 and step.length_m >= 0 for step in output.steps)
        assert 0.0 <= output.pending_fraction <= 1.0
    times = [step.time_s for output in run(*batches) for step in output.steps]
    assert times == sorted(times)


def test_a_phone_without_accelerometer_has_no_steps_and_says_so() -> None:
    output = run(WALK.batch("gyroscope", "magnetometer", "rotation_vector"))[0]
    assert output.steps == ()
    assert output.inertial_until_s is None
    assert output.motion is Motion.UNKNOWN


def test_an_empty_batch_repeats_what_was_known() -> None:
    (_, before), (_, after) = (
        advance_pdr(*(advance_pdr(initial_pdr_state(), WALK.batches([START_S + 8.0])[0])[0], batch))
        for batch in (Batch(1, None), Batch(2, START_S + 20.0))
    )
    assert before == after or astuple(before)[1:] == astuple(after)[1:]
    assert after.steps == ()


def test_later_steps_come_within_four_tenths_of_a_second_and_the_first_within_two_seconds() -> None:
    steps = []
    for cut, output in zip(
        np.arange(0.1, 16.0, 0.1), run(*WALK.batches(START_S + np.arange(0.1, 16.0, 0.1))), strict=False
    ):
        steps += [(step.time_s, START_S + cut - step.time_s) for step in output.steps]
    latency = np.array([late for _, late in steps])
    assert latency[:4].max() < 2.2
    assert latency[4:].max() < 0.5


def test_the_share_of_a_step_in_progress_grows_from_one_to_the_next() -> None:
    outputs = run(*WALK.batches(START_S + np.arange(0.05, 16.0, 0.05)))
    walking = [o for o in outputs if o.inertial_until_s and 6.0 < o.inertial_until_s - START_S < 13.0]
    shares = np.array([output.pending_fraction for output in walking])
    assert shares.min() > 0.0
    growth = np.diff(shares)
    assert np.all((growth >= 0) | (growth < -0.4))
    assert np.sum(growth < -0.4) == pytest.approx(7.0 * 1.8, abs=1)
    assert outputs[-1].pending_fraction == 0.0


def test_a_walker_is_walking_and_then_standing() -> None:
    outputs = run(*WALK.batches(START_S + np.arange(1.0, 16.0)))
    motions = [output.motion for output in outputs]
    assert motions[1] is Motion.STILL
    assert set(motions[5:13]) == {Motion.WALKING}
    assert motions[-1] is Motion.STILL
    assert outputs[-1].still_since_s == pytest.approx(START_S + 14.0, abs=1.3)


@pytest.mark.parametrize("silence_s", [0.6, 3.0, 60.0])
def test_a_gap_in_all_streams_makes_no_steps_and_the_walk_goes_on_after(silence_s: float) -> None:
    whole = walked(0.7, seconds=30.0)

    def cut(samples: AxisSamples) -> AxisSamples:
        keep = (samples.time_s < START_S + 14.0) | (samples.time_s >= START_S + 14.5)
        time_s = np.where(samples.time_s > START_S + 14.2, samples.time_s - 0.5 + silence_s, samples.time_s)
        return AxisSamples(time_s[keep], samples.values[keep])

    steps = run(Phone(*(cut(getattr(whole, name)) for name in STREAMS)).batch())[0].steps
    inside = [s for s in steps if START_S + 14.3 < s.time_s < START_S + 13.9 + silence_s]
    assert len(inside) <= 1
    assert 47 <= len(steps) <= 55
    assert np.degrees([s.heading_rad for s in steps]) == pytest.approx(np.degrees(0.7), abs=6.0)


@pytest.mark.parametrize("rates_hz", [(50.0, 200.0, 10.0), (100.0, 20.0, 50.0), (25.0, 100.0, 5.0)])
def test_streams_of_different_rates_work_together(rates_hz: tuple[float, float, float]) -> None:
    phones = [walked(1.2, rate_hz=rate, jitter=0.3) for rate in rates_hz]
    nothing = AxisSamples()
    mixed = Phone(phones[0].accelerometer, phones[1].gyroscope, phones[2].magnetometer, nothing)
    output = run(mixed.batch("accelerometer", "gyroscope", "magnetometer"))[0]
    assert abs(len(output.steps) - 54) <= 2
    assert np.degrees([s.heading_rad for s in output.steps]) == pytest.approx(np.degrees(1.2), abs=6.0)
