"""A phone that is carried through a building: everything it would log, and the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from app.observations import PressureSamples
from app.simulation.access_points import AccessPoints, install_access_points
from app.simulation.barometer import Weather, pressures
from app.simulation.building import Building, SimulatedFloor, make_building
from app.simulation.climb import Climbing, climb
from app.simulation.imu import InertialRecord, feel, magnetic_disturbance
from app.simulation.random_field import RandomField
from app.simulation.walker import Person, Walk, walk_route
from app.simulation.wifi_scanner import SimulatedScan, scans_along


@dataclass(frozen=True, slots=True)
class Phone:
    """A phone model. offset_db : what its WiFi reads more than the surveyors' phone."""

    brand: str
    model: str
    offset_db: float
    has_rotation_vector: bool = True
    has_barometer: bool = True


SURVEY_PHONE = Phone("Simulated", "Surveyor", 0.0)
VISITOR_PHONES = (
    Phone("Simulated", "Surveyor", 0.0),
    Phone("Simulated", "Budget", -4.0, has_rotation_vector=False, has_barometer=False),
    Phone("Simulated", "Flagship", 3.0),
    Phone("Simulated", "Tablet", 1.5),
)


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A building with its radio and magnetic surroundings: all that is fixed while people walk through it."""

    building: Building
    access_points: AccessPoints
    disturbance: RandomField


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One walk: the truth, the sensors, and the scans, which are made as they are taken (once).

    barometer : empty of a phone that has none.
    """

    phone: Phone
    walk: Walk
    inertial: InertialRecord
    scans: Iterator[SimulatedScan]
    barometer: PressureSamples = field(default_factory=PressureSamples)


def make_world(name: str, kind: str, floor_count: int, seed: int) -> World:
    """The building that a name, kind and seed stand for; the same arguments give the same world.

    Raises
    ------
    InvalidInput : as make_building.
    """
    plan_rng, radio_rng, steel_rng = np.random.default_rng([seed, 1]).spawn(3)
    building = make_building(name, kind, floor_count, plan_rng)
    return World(building, install_access_points(building, radio_rng), magnetic_disturbance(steel_rng))


def record_walk(
    world: World,
    floor: SimulatedFloor,
    phone: Phone,
    start_s: float,
    length_m: float,
    rate_hz: float,
    rng: np.random.Generator,
) -> Recording:
    """Somebody new walks a random route of about length_m on a floor, beginning at start_s (Unix)."""
    walk = walk_route(floor, floor.route(rng, length_m), Person.draw(rng), start_s, rate_hz, rng)
    return carried(world, walk, phone, rng)


def record_climb(
    world: World,
    levels: tuple[int, ...],
    how: Climbing,
    phone: Phone,
    start_s: float,
    length_m: float,
    rate_hz: float,
    rng: np.random.Generator,
) -> Recording:
    """Somebody new walks about length_m on each of the levels in turn, and from one to the next by stairs or lift."""
    return carried(
        world, climb(world.building, levels, how, Person.draw(rng), start_s, length_m, rate_hz, rng), phone, rng
    )


def carried(world: World, walk: Walk, phone: Phone, rng: np.random.Generator) -> Recording:
    """What a phone in the hand records of a walk."""
    feel_rng, scan_rng, pressure_rng = rng.spawn(3)
    scans = scans_along(walk, world.access_points, phone.offset_db, scan_rng)
    barometer = pressures(walk, Weather.draw(pressure_rng), pressure_rng) if phone.has_barometer else PressureSamples()
    return Recording(phone, walk, feel(walk, world.disturbance, feel_rng), scans, barometer)
