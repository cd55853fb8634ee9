"""Steps are counted where feet fell, and not where a phone is only handled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, Batch, Motion
from app.pdr.attitude_state import POINTED
from app.pdr.tracker import PdrOutput, advance_pdr, initial_pdr_state
from tests.open_data import open_data
from tests.pdr.phones import START_S, recorded_steps, run, sensed, strides, walked

NO_SWING = ["ArmBand", "BackPocket", "FrontPocket", "InHand", "NeckPouch", "Purse"]
SWING = "Pixel_Jamie_Hard_SwingingArm_1"
MINUTE_HZ = 100
ELAPSED_S = np.arange(60 * MINUTE_HZ) / MINUTE_HZ


def count_error(folder: str) -> tuple[float, float]:
    """Relative error of the count: against strides of both feet, and against every closing of the foot switches."""
    force, left, right = recorded_steps(open_data("oxford_steps", folder))
    count = len(run(Batch(0, None, accelerometer=force))[0].steps)
    return count / (strides(left) + strides(right)) - 1.0, count / (len(left) + len(right)) - 1.0


def test_the_six_recordings_without_swing_are_counted_within_one_and_a_half_percent_on_average() -> None:
    errors = np.abs([count_error(f"Samsung_Dario_Hard_{place}_1") for place in NO_SWING])
    by_strides, by_contacts = errors.mean(axis=0)
    assert by_strides <= 0.008
    assert by_contacts <= 0.015


def test_the_swinging_arm_is_counted_within_six_percent() -> None:
    by_strides, by_contacts = count_error(SWING)
    assert abs(by_strides) <= 0.06
    # a switch of this recording chatters: 284 contacts for 264 strides
    assert -0.08 <= by_contacts < 0.0


@pytest.mark.parametrize(
    "trial", ["02_undisturbed_slow_rotation_B", "10_undisturbed_slow_translation_A", "32_disturbed_attached_magnet_1cm"]
)
def test_minutes_of_turning_and_waving_by_hand_are_no_steps(trial: str) -> None:
    recording = loadmat(open_data("broad", f"{trial}.mat"))
    time_s = np.arange(len(recording["imu_acc"])) / float(recording["sampling_rate"][0, 0])
    force = AxisSamples(time_s, np.ascontiguousarray(recording["imu_acc"]))
    rate = AxisSamples(time_s, np.ascontiguousarray(recording["imu_gyr"]))
    assert run(Batch(0, None, accelerometer=force))[0].steps == ()
    assert run(Batch(0, None, accelerometer=force, gyroscope=rate))[0].steps == ()


def steps_of(attitude: Rotation, force_mps2: FloatArray, *streams: str) -> int:
    phone = sensed(START_S + ELAPSED_S, attitude, force_mps2)
    return len(run(phone.batch(*streams))[0].steps)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("turns_hz", [0.3, 0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("lever_m", [0.0, 0.1, 0.3])
def test_turning_the_phone_to_and_fro_makes_no_steps(axis: str, turns_hz: float, lever_m: float) -> None:
    angle = np.radians(45.0) * np.sin(2.0 * np.pi * turns_hz * ELAPSED_S)
    attitude = Rotation.from_euler(axis, angle[:, None])
    place = attitude.apply([0.0, lever_m, 0.0])
    force = np.gradient(np.gradient(place, axis=0), axis=0) * MINUTE_HZ**2
    assert steps_of(attitude, force) == 0


@pytest.mark.parametrize("shakes_hz", [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0])
@pytest.mark.parametrize("amplitude_mps2", [3.0, 8.0, 15.0, 25.0])
def test_shaking_the_phone_sideways_makes_no_steps(shakes_hz: float, amplitude_mps2: float) -> None:
    force = np.outer(amplitude_mps2 * np.sin(2.0 * np.pi * shakes_hz * ELAPSED_S), [0.8, 0.6, 0.0])
    assert steps_of(Rotation.identity(len(force)), force, "accelerometer") == 0


@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (1.0, 0.0, 0.0)])
@pytest.mark.parametrize("shakes_hz", [3.0, 4.0, 5.0, 6.0, 8.0])
@pytest.mark.parametrize("amplitude_mps2", [5.0, 15.0, 30.0])
def test_shaking_faster_than_legs_move_makes_no_steps(
    direction: tuple[float, ...], shakes_hz: float, amplitude_mps2: float
) -> None:
    force = np.outer(amplitude_mps2 * np.sin(2.0 * np.pi * shakes_hz * ELAPSED_S), direction)
    assert steps_of(Rotation.identity(len(force)), force, "accelerometer") == 0


def test_violent_aimless_handling_makes_a_few_steps_a_minute_at_most() -> None:
    """Force of 2 to 12 m/s^2 and turns of half a radian, both random: a hand sometimes has a rhythm like legs."""
    counts = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        smooth = rng.uniform(0.04, 0.15) * MINUTE_HZ
        force = gaussian_filter1d(rng.normal(size=(len(ELAPSED_S), 3)), smooth, axis=0)
        force *= rng.uniform(2.0, 12.0) / force.std()
        turn = gaussian_filter1d(rng.normal(size=(len(ELAPSED_S), 3)), 1.5 * smooth, axis=0)
        turn *= rng.uniform(0.2, 1.0) / turn.std()
        counts.append(steps_of(Rotation.from_rotvec(turn), force))
    assert np.median(counts) == 0
    assert np.mean(counts) < 4


def test_ten_minutes_on_a_table_are_still_with_no_step_and_no_turn() -> None:
    time_s = START_S + np.arange(600 * 50) / 50.0
    phone = sensed(time_s, Rotation.from_euler("ZX", [1.0, 0.1]) * Rotation.identity(len(time_s)), np.zeros((30000, 3)))
    for streams in ((), ("accelerometer", "gyroscope"), ("accelerometer",)):
        state, outputs, headings = initial_pdr_state(), list[PdrOutput](), list[float]()
        for batch in phone.batches(START_S + np.arange(1.0, 600.0, 20.0), *streams):
            state, output = advance_pdr(state, batch)
            outputs.append(output)
            headings.append(float(state.attitude.scalars[POINTED]))
        assert all(output.steps == () for output in outputs)
        assert {output.motion for output in outputs[1:]} == {Motion.STILL}
        assert all(output.pending_fraction == 0.0 for output in outputs)
        assert outputs[-1].still_since_s == pytest.approx(START_S, abs=2.0)
        assert np.ptp(np.unwrap(headings[1:])) < np.radians(3.0)


@pytest.mark.parametrize("rate_hz", [20.0, 33.0, 50.0, 100.0, 200.0])
@pytest.mark.parametrize("steps_per_s", [1.2, 1.8, 2.5])
def test_every_step_is_found_at_any_rate_and_cadence(rate_hz: float, steps_per_s: float) -> None:
    phone = walked(rate_hz=rate_hz, steps_per_s=steps_per_s, jitter=0.5)
    for streams in ((), ("accelerometer",)):
        steps = run(phone.batch(*streams))[0].steps
        assert abs(len(steps) - 30.0 * steps_per_s) <= 2
        assert np.median([step.duration_s for step in steps]) == pytest.approx(1.0 / steps_per_s, rel=0.05)
        lengths = [step.length_m for step in steps[1:-1]]
        assert np.std(lengths) < 0.05 * np.mean(lengths)


def test_lengths_do_not_depend_on_the_rate() -> None:
    means = [
        np.mean([s.length_m for s in run(walked(rate_hz=hz).batch())[0].steps]) for hz in (25.0, 50.0, 100.0, 200.0)
    ]
    assert np.ptp(means) < 0.02 * np.mean(means)


def test_the_instant_of_a_step_is_the_peak_of_the_acceleration() -> None:
    steps = run(walked(steps_per_s=1.8).batch())[0].steps[3:-3]
    phase = np.array([(step.time_s - START_S - 2.0) * 1.8 for step in steps])
    assert np.abs((phase - 0.22 + 0.5) % 1.0 - 0.5).max() < 0.1
