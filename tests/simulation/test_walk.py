from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt, find_peaks
from scipy.spatial.transform import Rotation

from app.simulation.recording import Recording, World
from tests.simulation.conftest import RATE_HZ, recorded


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), length_m=st.floats(10.0, 150.0))
def test_people_walk_at_the_pace_of_people(world: World, seed: int, length_m: float) -> None:
    walk = recorded(world, seed, length_m).walk
    assert walk.speed_mps.max() < 2.2
    assert walk.speed_mps.min() > -0.01
    assert np.linalg.norm(np.diff(walk.xy_m, axis=0), axis=1).max() < 2.2 / RATE_HZ
    going = walk.speed_mps > 0.8
    if going.sum() > 5 * RATE_HZ:
        step_m = walk.speed_mps[going].sum() / (np.gradient(walk.step_phase)[going].sum() * RATE_HZ)
        assert 0.4 < step_m < 0.95


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), length_m=st.floats(10.0, 150.0))
def test_waypoints_are_where_the_walker_was_at_that_time(world: World, seed: int, length_m: float) -> None:
    walk = recorded(world, seed, length_m).walk
    there = np.column_stack([np.interp(walk.waypoint_time_s, walk.time_s, walk.xy_m[:, axis]) for axis in (0, 1)])
    assert np.linalg.norm(there - walk.waypoint_xy_m, axis=1).max() < 0.1
    assert (np.diff(walk.waypoint_time_s) > 0.0).all()
    assert walk.waypoint_time_s[0] == walk.time_s[0]
    assert walk.waypoint_time_s[-1] == walk.time_s[-1]


def test_a_step_detector_counts_the_steps(recording: Recording) -> None:
    norm = np.linalg.norm(recording.inertial.accelerometer.values, axis=1)
    smooth = filtfilt(*butter(2, [0.7, 3.5], "bandpass", fs=RATE_HZ), norm)
    found, _ = find_peaks(smooth, height=0.6, distance=int(0.35 * RATE_HZ))
    assert len(found) == pytest.approx(recording.walk.step_phase[-1], rel=0.06)


def test_a_resting_phone_feels_gravity_alone(world: World) -> None:
    for seed in range(40):
        one = recorded(world, seed)
        rest = np.convolve(one.walk.speed_mps > 0.02, np.ones(25), "same") == 0
        if rest.sum() > RATE_HZ:
            norm = np.linalg.norm(one.inertial.accelerometer.values[rest], axis=1)
            assert norm.std() < 0.3
            assert norm.mean() == pytest.approx(9.81, abs=0.8)
            return
    pytest.fail("nobody paused in 40 walks")


def test_gyroscope_and_rotation_vector_tell_of_the_same_turns(recording: Recording) -> None:
    vector = recording.inertial.rotation_vector.values
    scalar = np.sqrt(np.clip(1.0 - (vector**2).sum(axis=1), 0.0, 1.0))
    attitude = Rotation.from_quat(np.column_stack([vector, scalar]))
    rate = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * RATE_HZ
    difference = recording.inertial.gyroscope.values[:-1] - rate
    assert np.abs(difference.mean(axis=0)).max() < 0.05
    assert difference.std() < 0.1


def test_the_rotation_vector_points_where_the_walker_goes(recording: Recording) -> None:
    vector = recording.inertial.rotation_vector.values
    scalar = np.sqrt(np.clip(1.0 - (vector**2).sum(axis=1), 0.0, 1.0))
    top = Rotation.from_quat(np.column_stack([vector, scalar])).apply([0.0, 1.0, 0.0])
    error = np.angle(np.exp(1j * (np.arctan2(top[:, 0], top[:, 1]) - recording.walk.heading_rad)))
    assert np.degrees(np.abs(error)).mean() < 30.0
    assert np.degrees(np.abs(error)).mean() > 1.0
