"""A phone in the hand is pushed to where its walker goes, whichever way it is held."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.evaluation.recordings import floor_folders, read_walk
from app.evaluation.truth import batches_of
from app.pdr.attitude import VERTICAL
from app.pdr.push import CELL_S, HELD_S, LEAD_RAD, felt_after, kept_of, push_rad
from app.pdr.tracker import advance_pdr, initial_pdr_state
from tests.open_data import open_data

STEP_S = 0.5


def felt_by(held_rad: float, rate_hz: float = 50.0, noise_mps2: float = 0.0, lead_rad: float = LEAD_RAD) -> FloatArray:
    """Three seconds of a walk with a phone that points this far to the left of it."""
    time_s = np.arange(0.0, 3.0, 1.0 / rate_hz)
    phase = 2.0 * np.pi * time_s / STEP_S
    forward, up = 0.5 * np.cos(phase + lead_rad), 3.0 * np.cos(phase) + 1.0 * np.cos(2.0 * phase)
    swayed = np.column_stack([forward * math.cos(held_rad), forward * math.sin(held_rad)])
    rng = np.random.default_rng(4)
    tracked = np.zeros((len(time_s), 7))
    tracked[:, VERTICAL] = 9.8 + up
    return felt_after(np.empty((0, 4)), time_s, tracked, swayed + rng.normal(0.0, noise_mps2, swayed.shape))


@given(
    held_rad=st.floats(-3.1, 3.1), rate_hz=st.sampled_from([25.0, 50.0, 100.0, 400.0]), lead_rad=st.floats(-0.6, 2.0)
)
def test_the_push_points_where_the_walker_goes(held_rad: float, rate_hz: float, lead_rad: float) -> None:
    found_rad = push_rad(felt_by(held_rad, rate_hz, lead_rad=lead_rad), 2.0, STEP_S)
    assert abs(math.remainder(found_rad - held_rad, math.tau)) < 0.1


def test_noise_turns_single_steps_but_not_the_mean_of_many() -> None:
    felt = felt_by(1.5, noise_mps2=0.5)
    found = np.array([push_rad(felt, end_s, STEP_S) for end_s in np.arange(0.6, 2.9, 0.1)])
    mean_rad = math.atan2(np.sin(found).mean(), np.cos(found).mean())
    assert abs(mean_rad - 1.5) < 0.3


@pytest.mark.parametrize(("end_s", "duration_s"), [(9.0, STEP_S), (2.0, 0.05)], ids=["no samples", "too few"])
def test_of_a_step_that_was_hardly_felt_nothing_is_said(end_s: float, duration_s: float) -> None:
    assert math.isnan(push_rad(felt_by(0.0), end_s, duration_s))


def test_a_phone_whose_screen_does_not_face_up_says_nothing() -> None:
    felt = felt_by(0.0)
    felt[:, 1:3] = math.nan
    assert math.isnan(push_rad(felt, 2.0, STEP_S))


def test_what_is_kept_is_bounded_whatever_the_rate() -> None:
    time_s = np.arange(0.0, 20.0, 0.001)
    felt = felt_after(np.empty((0, 4)), time_s, np.zeros((len(time_s), 7)), np.zeros((len(time_s), 2)))
    assert len(kept_of(felt)) <= HELD_S / CELL_S + 1


def test_on_recorded_walks_the_push_is_nearly_always_forward() -> None:
    """All of the recorded phones point where their walker goes."""
    (folder,) = floor_folders(open_data("mall"), ["F1"])
    means = []
    for path in folder.traces[:20]:
        walk = read_walk("F1", path)
        if walk is None:
            continue
        state, found = initial_pdr_state(), list[float]()
        for batch in batches_of(walk.trace, 5.0):
            state, output = advance_pdr(state, batch)
            found += [step.push_rad for step in output.steps if math.isfinite(step.push_rad)]
        if len(found) >= 20:
            means.append(math.atan2(np.sin(found).mean(), np.cos(found).mean()))
    assert len(means) >= 10
    assert np.mean(np.abs(means) < math.radians(60.0)) >= 0.9
