"""Simulated buildings that no setting was chosen on: surveyed by walks, published, and walked by strangers.

What a building is like follows from its seed (app/simulation/varied_world.py). The truth of a visit is known at every
second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from app.estimation.arrays import FloatArray
from app.evaluation.campaign import coverage_of, surveyed
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Coverage
from app.evaluation.truth import scan_places
from app.fusion.interface import Floor, Site
from app.simulation.access_points import AccessPoints
from app.simulation.building import SimulatedFloor
from app.simulation.imu import feel
from app.simulation.plan_files import plan_geojson
from app.simulation.recorded_trace import trace_of
from app.simulation.recording import SURVEY_PHONE, Phone, Recording, World
from app.simulation.site import EPOCH_S, LENGTH_M, WALKS_APART_S
from app.simulation.varied_world import Traits, varied_world
from app.simulation.walker import Person, walk_route
from app.simulation.wifi_scanner import scans_along
from app.survey.placement import fingerprints_of

VISIT_M = (45.0, 70.0)
"""Forty seconds to a minute."""
FEWEST_WALKS = 12
"""Of the survey of a floor, however small."""
WITH_ROTATION_VECTOR = 0.75
"""Share of the visitors' phones."""
WAYS_TO_CHOOSE = 4
"""A surveyor takes the one of so many random ways that leads most where nobody was yet."""
_RATE_HZ = 50.0
_SURVEY, _VISIT = 9, 10


@dataclass(frozen=True, slots=True, eq=False)
class NewBuilding:
    """A building as its visitors find it. site : with the radio map of the survey."""

    traits: Traits
    world: World
    survey: tuple[RecordedWalk, ...]
    site: Site
    coverage: Coverage


def new_building(traits: Traits) -> NewBuilding:
    """Build and survey; the same traits give the same."""
    world = varied_world(traits)
    survey = tuple(walk for floor in world.building.floors for walk in _survey_walks(world, floor, traits))
    folders = [
        FloorFolder(
            Floor(floor.floor, floor.level, floor.width_m, floor.height_m, world.building.georeference),
            None,
            (),
            plan_geojson(world.building, floor),
        )
        for floor in world.building.floors
    ]
    site = surveyed(folders, survey)
    return NewBuilding(traits, world, survey, site, coverage_of(survey))


def visits(building: NewBuilding, count: int, access_points: AccessPoints | None = None) -> Iterator[RecordedWalk]:
    """So many walks of strangers through the floors in turn.

    Parameters
    ----------
    access_points : that they hear instead of those that were surveyed; the ways and the sensors stay the same.
    """
    world, traits = building.world, building.traits
    world = world if access_points is None else replace(world, access_points=access_points)
    for number in range(count):
        rng = np.random.default_rng([traits.seed, _VISIT, number])
        floor = world.building.floors[number % traits.floors]
        offset_db = float(rng.normal(0.0, traits.offset_spread_db))
        phone = Phone("Simulated", "Stranger", offset_db, bool(rng.random() < WITH_ROTATION_VECTOR))
        start_s = EPOCH_S + WALKS_APART_S * (100_000 + number)
        corners_m = floor.route(rng, float(rng.uniform(*VISIT_M)))
        recording = _recorded(world, floor, phone, start_s, corners_m, traits.unrest, rng)
        trace = trace_of(recording, world.access_points, f"{traits.name}-visit-{number:04d}")
        time_s = np.rint(1000.0 * np.arange(recording.walk.time_s[0], recording.walk.time_s[-1], 1.0)) / 1000.0
        places = np.column_stack([np.interp(time_s, recording.walk.time_s, axis) for axis in recording.walk.xy_m.T])
        trace = replace(trace, waypoint_time_s=time_s, waypoint_xy_m=places)
        yield RecordedWalk(floor.floor, trace, (), np.empty((0, 2)))


def _survey_walks(world: World, floor: SimulatedFloor, traits: Traits) -> Iterator[RecordedWalk]:
    """Walks of a surveyor, mostly short, until there are enough for the size of the floor."""
    wanted_m, walked_m, number = traits.survey_m_per_m2 * _area_m2(floor.layout.outline), 0.0, 0
    walked = np.empty((0, 2))
    while walked_m < wanted_m or number < FEWEST_WALKS:
        rng = np.random.default_rng([traits.seed, _SURVEY, floor.level, number])
        length_m = float(np.exp(rng.uniform(*np.log(LENGTH_M))))
        start_s = EPOCH_S + WALKS_APART_S * (number + 1000 * floor.level)
        ways = [floor.route(rng, length_m) for _ in range(WAYS_TO_CHOOSE)]
        corners_m = max(ways, key=lambda way_m: _newness_m(way_m, walked))
        recording = _recorded(world, floor, SURVEY_PHONE, start_s, corners_m, traits.unrest, rng)
        trace = trace_of(recording, world.access_points, f"{traits.name}-{floor.floor}-survey-{number:03d}")
        yield RecordedWalk(floor.floor, trace, tuple(fingerprints_of(trace, floor.floor)[0]), scan_places(trace))
        walked = np.vstack([walked, recording.walk.xy_m[:: int(_RATE_HZ)]])
        walked_m += float(np.hypot(*np.diff(recording.walk.xy_m, axis=0).T).sum())
        number += 1


def _newness_m(way_m: FloatArray, walked: FloatArray) -> float:
    """How far the corners and middles of a way are, in the mean, from what was walked; 0 on the first walk."""
    places = np.vstack([way_m, (way_m[1:] + way_m[:-1]) / 2.0])
    return float(cKDTree(walked).query(places)[0].mean()) if len(walked) else 0.0


def _recorded(
    world: World,
    floor: SimulatedFloor,
    phone: Phone,
    start_s: float,
    corners_m: FloatArray,
    unrest: float,
    rng: np.random.Generator,
) -> Recording:
    walk = walk_route(floor, corners_m, Person.draw(rng), start_s, _RATE_HZ, rng)
    feel_rng, scan_rng = rng.spawn(2)
    scans = scans_along(walk, world.access_points, phone.offset_db, scan_rng, unrest=unrest)
    return Recording(phone, walk, feel(walk, world.disturbance, feel_rng), scans)


def _area_m2(outline: Sequence[tuple[float, float]]) -> float:
    """Of a polygon, by the shoelace formula."""
    x, y = np.array(outline).T
    return math.fabs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2.0
