"""The paper's attitude filter against rotations integrated elsewhere, its Jacobians against differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples
from app.pdr.attitude_ekf import (
    HEADING,
    PAPER_ATTITUDE,
    PITCH,
    RATE_X,
    ROLL,
    AttitudeNoise,
    EulerState,
    advance_attitude,
    lean,
    turn,
)
from app.pdr.gravity import GRAVITY_MPS2
from tests.pdr.phones import inertial_batch

QUIET = AttitudeNoise()
Angles = tuple[float, float, float]
Rates = tuple[float, float, float]
ANGLES = st.tuples(st.floats(-3.0, 3.0), st.floats(-1.2, 1.2), st.floats(-3.0, 3.0))
RATES = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def body_to_level(heading: float, pitch: float, roll: float) -> Rotation:
    """The rotation whose derivative Eq. 12 is: roll about y, then pitch about x, then clockwise about z."""
    return Rotation.from_euler("ZXY", [-heading, pitch, roll])


def values_of(heading: float, pitch: float, roll: float, rate: Rates = (0.0, 0.0, 0.0)) -> FloatArray:
    values = np.zeros(10)
    values[[HEADING, PITCH, ROLL]] = heading, pitch, roll
    values[RATE_X : RATE_X + 3] = rate
    return values


def tilted(
    force_of: Rotation, rate: FloatArray, seconds: float, rate_hz: float = 50.0
) -> list[tuple[str, AxisSamples]]:
    time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    force = np.tile(force_of.inv().apply([0.0, 0.0, GRAVITY_MPS2]), (len(time_s), 1))
    return [
        ("accelerometer", AxisSamples(time_s, force)),
        ("gyroscope", AxisSamples(time_s, np.tile(rate, (len(time_s), 1)))),
    ]


@settings(deadline=None)
@given(angles=ANGLES, rate=RATES)
def test_a_turn_is_that_of_the_rotation(angles: Angles, rate: Rates) -> None:
    values, interval_s = values_of(*angles, rate=rate), 1e-5
    turn(values, np.eye(3), np.array(rate), interval_s, 0.0)
    expected = body_to_level(*angles) * Rotation.from_rotvec(np.array(rate) * interval_s)
    found = body_to_level(values[HEADING], values[PITCH], values[ROLL])
    assert (expected.inv() * found).magnitude() < 1e-7


@settings(deadline=None)
@given(angles=ANGLES, rate=RATES)
def test_the_jacobian_of_a_turn_is_that_of_differences(angles: Angles, rate: Rates) -> None:
    interval_s, small = 0.02, 1e-6

    def after(shifted: FloatArray) -> FloatArray:
        values = values_of(shifted[0], shifted[1], shifted[2], rate=rate)
        turn(values, np.eye(3), np.array(rate), interval_s, 0.0)
        return np.asarray(values[[HEADING, PITCH, ROLL]])

    start = np.array(angles)
    jacobian = np.empty((3, 3))
    for k in range(3):
        ahead, behind = start.copy(), start.copy()
        ahead[k] += small
        behind[k] -= small
        jacobian[:, k] = (after(ahead) - after(behind)) / (2.0 * small)
    covariance = np.array([[0.5, 0.1, 0.0], [0.1, 0.3, -0.1], [0.0, -0.1, 0.2]])
    expected = jacobian @ covariance @ jacobian.T
    values = values_of(*angles, rate=rate)
    turn(values, covariance, np.array(rate), interval_s, 0.0)
    assert covariance == pytest.approx(expected, abs=1e-5, rel=1e-4)


@settings(deadline=None)
@given(angles=ANGLES)
def test_gravity_as_expected_changes_no_angle(angles: Angles) -> None:
    values, covariance = values_of(*angles), np.eye(3)
    lean(values, covariance, body_to_level(*angles).inv().apply([0.0, 0.0, GRAVITY_MPS2]), 1.0)
    assert values[[HEADING, PITCH, ROLL]] == pytest.approx(angles, abs=1e-9)
    assert np.trace(covariance) < 3.0


def test_the_correction_is_that_of_a_kalman_filter() -> None:
    angles, covariance = np.array([0.4, 0.3, -0.5]), np.array([[0.5, 0.1, 0.0], [0.1, 0.3, -0.1], [0.0, -0.1, 0.2]])
    force = np.array([1.0, 4.0, 8.0])

    def expected_g(at: FloatArray) -> FloatArray:
        return np.asarray(body_to_level(at[0], at[1], at[2]).inv().apply([0.0, 0.0, 1.0]))

    jacobian = np.column_stack(
        [(expected_g(angles + 1e-6 * unit) - expected_g(angles - 1e-6 * unit)) / 2e-6 for unit in np.eye(3)]
    )
    gain = covariance @ jacobian.T @ np.linalg.inv(jacobian @ covariance @ jacobian.T + 0.7 * np.eye(3))
    mean = angles + gain @ (force / GRAVITY_MPS2 - expected_g(angles))
    after = (np.eye(3) - gain @ jacobian) @ covariance
    values = values_of(angles[0], angles[1], angles[2])
    lean(values, covariance, force, 0.7)
    assert values[[HEADING, PITCH, ROLL]] == pytest.approx(mean, abs=1e-6)
    assert covariance == pytest.approx(after, abs=1e-6)


@pytest.mark.parametrize("tilt", [(0.0, 0.0, 0.0), (0.0, 0.6, 0.0), (0.0, 0.3, -0.7)])
def test_a_phone_turned_about_the_vertical_turns_its_heading_by_as_much(tilt: Angles) -> None:
    held = body_to_level(*tilt)
    clockwise = held.inv().apply([0.0, 0.0, -0.5])
    state = advance_attitude(EulerState(), inertial_batch(0, dict(tilted(held, clockwise, 4.0))), QUIET)
    first, last = state.heading_at(0.0), state.heading_at(3.0)
    assert first is not None and last is not None
    assert last - first == pytest.approx(1.5, abs=0.02)


def test_the_tilt_is_learnt_from_gravity_alone() -> None:
    phone = dict(tilted(body_to_level(0.0, 0.4, -0.2), np.zeros(3), 5.0))
    state = advance_attitude(EulerState(), inertial_batch(0, phone), QUIET)
    assert state.values[[PITCH, ROLL]] == pytest.approx([0.4, -0.2], abs=1e-3)


def test_with_the_papers_noise_every_jolt_tilts_the_phone() -> None:
    rng = np.random.default_rng(2)
    phone = dict(tilted(body_to_level(0.0, 0.2, 0.0), np.zeros(3), 20.0))
    jolts = AxisSamples(phone["accelerometer"].time_s, phone["accelerometer"].values + rng.normal(0.0, 2.0, (1000, 3)))
    spread = []
    for noise in (QUIET, PAPER_ATTITUDE):
        state, pitches = EulerState(), []
        for until_s in np.arange(5.0, 20.0, 0.1):
            batch = inertial_batch(0, {**phone, "accelerometer": jolts})
            state = advance_attitude(state, batch, noise, until_s)
            pitches.append(state.values[PITCH])
        spread.append(np.std(pitches))
    assert spread[1] > 5.0 * spread[0]


def test_where_a_walk_is_cut_makes_no_difference() -> None:
    rng = np.random.default_rng(4)
    time_s = np.sort(rng.uniform(0.0, 6.0, 300))
    streams = {
        "accelerometer": AxisSamples(time_s, rng.normal(0.0, 1.0, (300, 3)) + [0.0, 0.0, 9.8]),
        "gyroscope": AxisSamples(time_s + 1e-3, rng.normal(0.0, 0.5, (300, 3))),
    }
    batch = inertial_batch(0, streams)
    whole, cut = advance_attitude(EulerState(), batch, QUIET), EulerState()
    for until_s in (0.5, 1.7, 1.71, 4.0, None):
        cut = advance_attitude(cut, batch, QUIET, until_s)
    assert np.array_equal(whole.values, cut.values) and np.array_equal(whole.covariance, cut.covariance)
    assert whole.heading_at(5.0) == cut.heading_at(5.0)


def test_a_gap_in_the_gyroscope_begins_another_stretch() -> None:
    time_s = np.concatenate([np.arange(0.0, 2.0, 0.02), np.arange(5.0, 6.0, 0.02)])
    rates = AxisSamples(time_s, np.tile([0.0, 0.0, 0.3], (len(time_s), 1)))
    early = advance_attitude(EulerState(), inertial_batch(0, {"gyroscope": rates}), QUIET, until_s=2.0)
    late = advance_attitude(early, inertial_batch(0, {"gyroscope": rates}), QUIET)
    assert late.stretch == early.stretch + 1
    assert late.noted[0, 0] == 5.0


def test_without_a_gyroscope_there_is_no_heading() -> None:
    still = AxisSamples(np.arange(0.0, 1.0, 0.02), np.tile([0.0, 0.0, 9.8], (50, 1)))
    assert advance_attitude(EulerState(), inertial_batch(0, {"accelerometer": still}), QUIET).heading_at(0.5) is None


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.sampled_from([1.0, 40.0, 1e4]),
    noise=st.sampled_from([QUIET, PAPER_ATTITUDE]),
    silent=st.booleans(),
)
def test_nonsense_leaves_everything_finite(seed: int, size: float, noise: AttitudeNoise, silent: bool) -> None:
    rng = np.random.default_rng(seed)
    time_s = np.sort(rng.uniform(0.0, 30.0, 400))
    streams = {"gyroscope": AxisSamples(time_s, rng.normal(0.0, size, (400, 3)))}
    if not silent:
        streams["accelerometer"] = AxisSamples(time_s, rng.normal(0.0, size, (400, 3)))
    state = advance_attitude(EulerState(), inertial_batch(0, streams), noise)
    assert (
        np.isfinite(state.values[2:9]).all() and np.isfinite(state.covariance).all() and np.isfinite(state.noted).all()
    )
    heading = state.heading_at(20.0)
    assert heading is not None and math.isfinite(heading)
