"""A carried phone feels the walk of the person who carries it, each place in its own way."""

from __future__ import annotations

import numpy as np
import pytest

from app.observations import Batch, Carrying
from app.pdr.carrying_position import CLASSES
from app.pdr.tracker import advance_pdr, initial_pdr_state
from app.simulation.carrying import Bearing, feel_carried
from app.simulation.imu import InertialRecord
from app.simulation.recording import World
from app.simulation.walker import Person, Walk, walk_route
from tests.simulation.conftest import RATE_HZ, START_S


def walk_of(world: World, seed: int = 3) -> Walk:
    rng = np.random.default_rng(seed)
    floor = world.building.floors[0]
    return walk_route(floor, floor.route(rng, 60.0), Person.draw(rng), START_S, RATE_HZ, rng)


def felt(world: World, position: Carrying, seed: int = 3) -> InertialRecord:
    rng = np.random.default_rng(seed)
    return feel_carried(walk_of(world, seed), position, Bearing.draw(rng), world.disturbance, rng)


@pytest.mark.parametrize("position", CLASSES)
def test_the_same_seed_gives_the_same_samples_and_another_seed_others(world: World, position: Carrying) -> None:
    one, same, other = (felt(world, position, seed) for seed in (3, 3, 4))
    assert np.array_equal(one.accelerometer.values, same.accelerometer.values)
    assert np.array_equal(one.gyroscope.values, same.gyroscope.values)
    count = min(len(one.accelerometer.values), len(other.accelerometer.values))
    assert not np.array_equal(one.accelerometer.values[:count], other.accelerometer.values[:count])


@pytest.mark.parametrize("position", CLASSES)
def test_gravity_is_all_that_is_left_on_average(world: World, position: Carrying) -> None:
    record = felt(world, position)
    assert np.isfinite(record.accelerometer.values).all() and np.isfinite(record.gyroscope.values).all()
    norm = np.linalg.norm(record.accelerometer.values, axis=1)
    assert 9.3 < norm.mean() < 16.0
    field = np.linalg.norm(record.magnetometer.values, axis=1)
    assert 25.0 < np.median(field) < 60.0


def turning(record: InertialRecord) -> float:
    return float(np.sqrt(np.mean(record.gyroscope.values**2)))


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_limbs_swing_and_heads_and_looked_at_hands_do_not(world: World, seed: int) -> None:
    hand, pocket, call, swinging = (turning(felt(world, position, seed)) for position in CLASSES)
    assert min(pocket, swinging) > max(hand, call)


def test_a_limb_swings_once_a_stride_and_a_step_comes_twice(world: World) -> None:
    walk = walk_of(world)
    strides_hz = np.diff(walk.step_phase[[0, -1]])[0] / 2.0 / np.ptp(walk.time_s)
    spin = felt(world, Carrying.SWINGING).gyroscope.values
    spin = spin[:, np.var(spin, axis=0).argmax()]
    spectrum = np.abs(np.fft.rfft(spin - spin.mean()))
    frequency = np.fft.rfftfreq(len(spin), 1.0 / RATE_HZ)
    assert frequency[spectrum.argmax()] == pytest.approx(strides_hz, rel=0.2)


@pytest.mark.parametrize("position", [Carrying.HANDHELD, Carrying.CALL])
def test_its_steps_can_be_counted(world: World, position: Carrying) -> None:
    walk, record = walk_of(world), felt(world, position)
    batch = Batch(0, None, accelerometer=record.accelerometer, gyroscope=record.gyroscope)
    _, output = advance_pdr(initial_pdr_state(), batch)
    assert len(output.steps) == pytest.approx(walk.step_phase[-1], rel=0.15)


def test_there_is_no_other_position(world: World) -> None:
    with pytest.raises(KeyError):
        felt(world, Carrying.UNKNOWN)
