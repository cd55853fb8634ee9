"""Attitude against optical truth (BROAD), against Madgwick's filter on the same trials, and on synthetic phones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from ahrs.filters import Madgwick
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import ABSOLUTE_BELOW_RAD, AxisSamples, Step
from app.pdr import attitude
from app.pdr.attitude_state import AttitudeState
from app.pdr.compass import DELTA
from app.pdr.gyroscope_stuck import gyroscope_stuck
from app.pdr.quaternion import multiply
from app.pdr.tracker import advance_pdr, initial_pdr_state
from tests.open_data import open_data
from tests.pdr.phones import START_S, Phone, run, sensed, walked

TRIALS = ["02_undisturbed_slow_rotation_B", "10_undisturbed_slow_translation_A", "32_disturbed_attached_magnet_1cm"]
MADGWICK_GAIN = 0.12
HEADING_LIMIT_DEG = {TRIALS[0]: 1.5, TRIALS[1]: 2.1, TRIALS[2]: 9.0}


def own_attitudes(time_s: FloatArray, force: FloatArray, rate: FloatArray, field: FloatArray) -> Rotation:
    """The filter's attitude after each sample; all sensors sampled together."""
    arrays, answer, swayed = AttitudeState().arrays(), np.empty((len(time_s), 7)), np.empty((len(time_s), 2))
    quaternions, offsets = np.empty((len(time_s), 4)), np.empty(len(time_s))
    none, nothing = np.empty(0), np.empty((0, 3))
    for i in range(len(time_s)):
        now = slice(i, i + 1)
        attitude.track(
            arrays,
            time_s[now],
            force[now],
            time_s[now],
            rate[now],
            time_s[now],
            field[now],
            none,
            nothing,
            answer[now],
            swayed[now],
        )
        multiply(arrays[3], arrays[2], quaternions[i])
        offsets[i] = arrays[10][DELTA]
    level = Rotation.from_quat(np.roll(quaternions, -1, axis=1))
    return Rotation.from_rotvec(np.outer(-offsets, [0.0, 0.0, 1.0])) * level


def heading_rmse_deg(estimate: Rotation, truth: FloatArray, moving: FloatArray) -> float:
    """BROAD's heading error, the rotation about the vertical in estimate * truth^-1, over the moving phase.

    Both are relative to magnetic north and up; nothing is aligned.
    """
    use = (moving > 0) & np.isfinite(truth).all(axis=1)
    error = (estimate[use] * Rotation.from_quat(np.roll(truth[use], -1, axis=1)).inv()).as_quat()
    angle = np.remainder(2.0 * np.arctan2(error[:, 2], error[:, 3]) + np.pi, 2.0 * np.pi) - np.pi
    return float(np.degrees(np.sqrt(np.mean(angle**2))))


@pytest.mark.parametrize("trial", TRIALS)
def test_the_heading_is_better_than_madgwicks_on_the_same_trial(trial: str) -> None:
    recording = loadmat(open_data("broad", f"{trial}.mat"))
    force, rate, field = (np.ascontiguousarray(recording[name]) for name in ("imu_acc", "imu_gyr", "imu_mag"))
    rate_hz = float(recording["sampling_rate"][0, 0])
    ours = own_attitudes(np.arange(len(force)) / rate_hz, force, rate, field)
    madgwick = Madgwick(gyr=rate, acc=force, mag=field, frequency=rate_hz, gain=MADGWICK_GAIN).Q
    # Madgwick's reference has x north, y west; ours x east, y north
    theirs = Rotation.from_euler("z", 90.0, degrees=True) * Rotation.from_quat(np.roll(madgwick, -1, axis=1))
    truth, moving = recording["opt_quat"], recording["movement"].ravel()
    error = heading_rmse_deg(ours, truth, moving)
    assert error <= heading_rmse_deg(theirs, truth, moving)
    assert error <= HEADING_LIMIT_DEG[trial]
    assert np.isfinite(ours.as_quat()).all()


def headings_deg(phone: Phone, *streams: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of the steps after the first five: heading, its standard deviation, and turn since the step before, degrees."""
    steps = run(phone.batch(*streams))[0].steps[5:]
    assert len(steps) > 20
    table = np.array([(s.heading_rad, s.heading_sigma_rad, s.heading_change_rad) for s in steps])
    return tuple(np.degrees(table).T)


@pytest.mark.parametrize(
    "streams",
    [
        ("accelerometer", "gyroscope", "magnetometer", "rotation_vector"),
        ("accelerometer", "rotation_vector"),
        ("accelerometer", "gyroscope", "magnetometer"),
        ("accelerometer", "magnetometer"),
    ],
)
@pytest.mark.parametrize("heading_rad", [0.0, 1.5, 3.1, -2.0])
def test_any_absolute_reference_gives_the_walking_direction(streams: tuple[str, ...], heading_rad: float) -> None:
    heading, sigma, _ = headings_deg(walked(heading_rad), *streams)
    assert np.abs((heading - np.degrees(heading_rad) + 180.0) % 360.0 - 180.0).max() < 5.0
    assert sigma.max() < 30.0 and np.radians(sigma.max()) < ABSOLUTE_BELOW_RAD


def test_without_compass_the_heading_is_relative_and_says_so() -> None:
    phone = walked(turn_rad_per_s=0.2)
    heading, sigma, change = headings_deg(phone, "accelerometer", "gyroscope")
    assert sigma == pytest.approx(180.0)
    turned = np.degrees(np.unwrap(np.radians(heading)))
    expected = np.degrees(0.2) / 1.8
    assert np.diff(turned) == pytest.approx(expected, abs=1.0)
    assert change == pytest.approx(expected, abs=1.0)


def test_the_turn_between_steps_comes_from_the_gyroscope_alone() -> None:
    phone = walked(turn_rad_per_s=-0.3)
    steel = AxisSamples(phone.magnetometer.time_s, phone.magnetometer.values[::-1] + 60.0)
    bent = Phone(phone.accelerometer, phone.gyroscope, steel, phone.rotation_vector)
    _, _, change = headings_deg(bent, "accelerometer", "gyroscope", "magnetometer")
    assert change == pytest.approx(np.degrees(-0.3) / 1.8, abs=1.0)


def test_steel_for_ten_seconds_does_not_turn_the_heading() -> None:
    phone = walked(0.5, seconds=60.0)
    elapsed = phone.magnetometer.time_s - START_S
    field = phone.magnetometer.values + np.where((elapsed > 30) & (elapsed < 40), 12.0, 0.0)[:, None]
    bent = Phone(phone.accelerometer, phone.gyroscope, AxisSamples(phone.magnetometer.time_s, field), phone.gyroscope)
    heading, sigma, _ = headings_deg(bent, "accelerometer", "gyroscope", "magnetometer")
    assert np.abs(heading - np.degrees(0.5)).max() < 5.0
    steps = run(bent.batch("accelerometer", "magnetometer", "gyroscope"))[0].steps
    compass = np.array([s.magnetic_heading_rad for s in steps if 31.0 < s.time_s - START_S < 39.0])
    assert np.abs(np.degrees(compass - 0.5)).min() > 10.0
    assert sigma.max() > sigma[0]


def broken(phone: Phone, **streams: FloatArray) -> Phone:
    """The phone with the values of some streams replaced."""
    return replace(phone, **{name: AxisSamples(getattr(phone, name).time_s, to) for name, to in streams.items()})


def test_a_magnet_at_the_phone_is_no_compass() -> None:
    phone = walked(0.5, seconds=60.0)
    late = (phone.magnetometer.time_s - START_S > 30.0)[:, None]
    magnetised = broken(phone, magnetometer=phone.magnetometer.values + late * np.array([150.0, 0.0, 0.0]))
    steps = run(magnetised.batch("accelerometer", "gyroscope", "magnetometer"))[0].steps
    heading = np.array([step.heading_rad for step in steps[5:]])
    assert np.abs(np.degrees(heading - 0.5)).max() < 5.0
    told = np.array([math.isfinite(step.magnetic_heading_rad) for step in steps])
    since_s = np.array([step.time_s - START_S for step in steps])
    assert told[since_s < 29.0].all()
    assert not told[since_s > 31.0].any()


@pytest.mark.parametrize("compass", [True, False])
def test_a_gyroscope_that_repeats_itself_gives_way_to_a_compass(compass: bool) -> None:
    phone = walked(0.5, seconds=40.0, turn_rad_per_s=0.1)
    rate = phone.gyroscope.values
    stuck_from = np.searchsorted(phone.gyroscope.time_s, START_S + 20.0)
    stuck = broken(phone, gyroscope=rate[np.minimum(np.arange(len(rate)), stuck_from)])
    streams = ("accelerometer", "gyroscope", "magnetometer") if compass else ("accelerometer", "gyroscope")
    state, steps = initial_pdr_state(), list[Step]()
    for batch in stuck.batches([START_S + 19.0, START_S + 35.0], *streams):
        state, moved = advance_pdr(state, batch)
        steps += moved.steps
    assert gyroscope_stuck(state.attitude.scalars, state.attitude.rest, state.attitude.magnetic) == compass
    last = [step for step in steps if step.time_s - START_S > 30.0]
    expected = np.array([0.5 + 0.1 * (step.time_s - START_S - 2.0) for step in last])
    if compass:
        astray_rad = np.array([step.heading_rad for step in last]) - expected
        assert np.abs(np.remainder(astray_rad + math.pi, math.tau) - math.pi).max() < 0.2
        assert [step.heading_sigma_rad for step in last] == pytest.approx([attitude.SIGMA_NO_GYRO] * len(last))


def test_a_phone_that_lies_still_may_repeat_itself() -> None:
    time_s = START_S + np.arange(1000) / 50.0
    lying = broken(
        sensed(time_s, Rotation.identity(1000), np.zeros((1000, 3))),
        gyroscope=np.zeros((1000, 3)),
    )
    state, _ = advance_pdr(initial_pdr_state(), lying.batch("accelerometer", "gyroscope", "magnetometer"))
    assert not gyroscope_stuck(state.attitude.scalars, state.attitude.rest, state.attitude.magnetic)


def test_a_bias_of_the_gyroscope_is_learnt_while_the_phone_lies_still() -> None:
    time_s = START_S + np.arange(6000) / 50.0
    phone = sensed(time_s, Rotation.identity(6000), np.zeros((6000, 3)))
    biased = AxisSamples(time_s, phone.gyroscope.values + np.radians([0.5, -0.5, 0.8]))
    arrays = AttitudeState().arrays()
    none, nothing, answer, swayed = np.empty(0), np.empty((0, 3)), np.empty((6000, 7)), np.empty((6000, 2))
    force = phone.accelerometer.values
    attitude.track(arrays, time_s, force, time_s, biased.values, none, nothing, none, nothing, answer, swayed)
    assert np.degrees(arrays[6]) == pytest.approx([0.5, -0.5, 0.8], abs=0.05)
    assert abs(np.degrees(answer[-1, attitude.HEADING] - answer[3000, attitude.HEADING])) < 0.5


def test_when_the_rotation_vector_ends_the_heading_does_not_jump() -> None:
    phone = walked(1.0)
    keep = phone.rotation_vector.time_s < START_S + 18.0
    twisted = Rotation.from_rotvec([0.0, 0.0, 0.3]) * Rotation.from_quat(
        [[*v, math.sqrt(max(0.0, 1.0 - v @ v))] for v in phone.rotation_vector.values]
    )
    vector = np.ascontiguousarray(twisted.as_quat(canonical=True)[keep, :3])
    following = AxisSamples(phone.accelerometer.time_s[keep], vector)
    ended = Phone(phone.accelerometer, phone.gyroscope, phone.magnetometer, following)
    steps = run(ended.batch())[0].steps
    heading = np.array([s.heading_rad for s in steps])
    assert heading[[s.time_s < START_S + 17.0 for s in steps]] == pytest.approx(0.7, abs=0.01)
    assert np.abs(np.diff(heading)).max() < 0.05
