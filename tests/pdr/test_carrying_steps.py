"""What a step is and how long, by where the phone is carried."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.estimation.arrays import FloatArray
from app.observations import Batch, Carrying
from app.pdr.carried_phone import CarriedPhone, advance_carried
from app.pdr.carried_state import NORM
from app.pdr.carrying_position import CLASSES
from app.pdr.carrying_steps import LONGEST_M, SHORTEST_M, constants_of, is_step, step_length_m
from app.pdr.gravity import GRAVITY_MPS2
from app.pdr.quaternion_ukf import QuaternionNoise
from app.pdr.tracker import advance_pdr, initial_pdr_state
from app.simulation.carrying import Bearing, feel_carried
from app.simulation.recording import World, make_world
from app.simulation.walker import Person, walk_route


def cells(peak_mps2: float) -> FloatArray:
    found = np.zeros((12, 8))
    found[:, NORM] = GRAVITY_MPS2 + peak_mps2 * np.sin(np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False))
    return found


@pytest.mark.parametrize("carrying", CLASSES)
def test_a_peak_counts_above_the_height_of_its_position(carrying: Carrying) -> None:
    height = constants_of(carrying).peak_mps2
    assert is_step(cells(1.1 * height), 0.5, math.nan, carrying)
    assert not is_step(cells(0.9 * height), 0.5, math.nan, carrying)


def test_two_steps_are_two_thirds_of_the_usual_time_apart() -> None:
    assert is_step(cells(5.0), 0.35, 0.5, Carrying.HANDHELD)
    assert not is_step(cells(5.0), 0.32, 0.5, Carrying.HANDHELD)
    assert is_step(cells(5.0), 0.32, math.nan, Carrying.HANDHELD)


def test_an_unknown_position_is_taken_for_the_hand() -> None:
    assert constants_of(Carrying.UNKNOWN) is constants_of(Carrying.HANDHELD)


@pytest.mark.parametrize("carrying", [*CLASSES, Carrying.UNKNOWN])
@pytest.mark.parametrize("duration_s", [0.01, 0.5, 0.95, 4.0])
@pytest.mark.parametrize("peak_mps2", [0.0, 5.0, 50.0])
def test_a_length_is_one_that_legs_have(carrying: Carrying, duration_s: float, peak_mps2: float) -> None:
    assert SHORTEST_M <= step_length_m(cells(peak_mps2), duration_s, carrying) <= LONGEST_M
    assert SHORTEST_M <= step_length_m(np.empty((0, 8)), duration_s, carrying) <= LONGEST_M


def lengths(world: World, position: Carrying, seed: int) -> tuple[float, float, int]:
    """Metres by the steps of a walk, its true length between the first and the last of them, and their number."""
    rng = np.random.default_rng([11, seed])
    floor = world.building.floors[0]
    walk = walk_route(floor, floor.route(rng, 60.0), Person.draw(rng), 1_700_000_000.0, 50.0, rng)
    felt = feel_carried(walk, position, Bearing.draw(rng), world.disturbance, rng)
    batch = Batch(0, None, accelerometer=felt.accelerometer, gyroscope=felt.gyroscope, magnetometer=felt.magnetometer)
    _, output = advance_pdr(initial_pdr_state(), batch)
    phone, total_m = CarriedPhone(), 0.0
    for step in output.steps:
        phone = advance_carried(phone, batch, QuaternionNoise(), step.time_s + 0.15)
        of_step = phone.motion.cells_between(step.time_s - step.duration_s, step.time_s)
        total_m += step_length_m(of_step, step.duration_s, position)
    way_m = sum(walk.moved_m(step.time_s - step.duration_s, step.time_s) for step in output.steps)
    return total_m, way_m, len(output.steps)


@pytest.mark.parametrize("position", [Carrying.POCKET, Carrying.CALL, Carrying.SWINGING])
def test_simulated_people_walk_as_far_as_their_steps_say(position: Carrying) -> None:
    world = make_world("carrying", "mall", 1, seed=9)  # another building and other people than the constants are of
    found = [lengths(world, position, seed) for seed in range(6)]
    by_steps_m, way_m = (sum(one[k] for one in found) for k in (0, 1))
    assert sum(one[2] for one in found) > 150
    assert by_steps_m == pytest.approx(way_m, rel=0.1)
