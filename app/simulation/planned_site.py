"""A floor as somebody describes it: its rooms, access points and reference points are given, not drawn.

What is drawn, as everywhere in the simulator, is what no description holds: shadowing, fading, the walkers' habits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.floorplan.georeference import Georeference
from app.observations import Carrying
from app.simulation.access_points import (
    CEILING_M,
    FREQUENCIES_24_MHZ,
    LONG_SHADOWING_DB,
    LONG_SHADOWING_M,
    SHORT_SHADOWING_DB,
    SHORT_SHADOWING_M,
    AccessPoints,
)
from app.simulation.building import STOREY_HEIGHT_M, Building, SimulatedFloor
from app.simulation.carrying import Bearing, feel_carried
from app.simulation.imu import feel, magnetic_disturbance
from app.simulation.layouts import Layout
from app.simulation.random_field import RandomField
from app.simulation.recording import SURVEY_PHONE, Recording, World
from app.simulation.walker import Person, walk_route
from app.simulation.walkways import Walkways
from app.simulation.walls import walls_of
from app.simulation.wifi_scanner import (
    BODY_LOSS_DB,
    DEAF_BELOW_DBM,
    FADING_DB,
    HAND_DB,
    HEARING_DBM,
    HEARING_WIDTH_DB,
    scans_along,
)
from app.wifi.fingerprint import Fingerprint

KIND = "office"
POWER_DBM, POWER_SPREAD_DB = -33.0, 3.0
"""Of an access point at 1 m: a consumer router's, and how routers differ."""
FLOOR = "F1"
TRAINED_BOUNCE = 0.372
"""Of a walker whose step length the Weinberg constant fits on average: every paper trains it on its own walker."""


def planned_world(name: str, layout: Layout, places: Sequence[tuple[float, float, int]], seed: int) -> World:
    """A building of one floor with this layout, along the axes of its frame.

    Parameters
    ----------
    places : x, y and level of every access point; those of other levels hang in storeys above and below.
    seed : the same arguments give the same world.
    """
    plan_rng, radio_rng, steel_rng = np.random.default_rng([seed, 4]).spawn(3)
    outline = np.array(layout.outline)
    low, high = outline.min(axis=0), outline.max(axis=0)
    if np.any(low != 0.0):
        raise ValueError("a planned layout begins at the origin")
    floor = SimulatedFloor(
        floor=FLOOR,
        level=0,
        storey_height_m=STOREY_HEIGHT_M[KIND],
        layout=layout,
        walls=walls_of(layout, plan_rng),
        walkways=Walkways.of(layout),
        rotation_rad=0.0,
        shift_m=(0.0, 0.0),
        width_m=float(high[0]),
        height_m=float(high[1]),
    )
    building = Building(name, KIND, Georeference(30.5, 114.3, 0.0), (floor,))
    return World(building, _access_points(building, places, radio_rng), magnetic_disturbance(steel_rng))


def _access_points(
    building: Building, places: Sequence[tuple[float, float, int]], rng: np.random.Generator
) -> AccessPoints:
    """Routers of one band and one network each."""
    count, storey_m = len(places), building.floors[0].storey_height_m
    return AccessPoints(
        building=building,
        place_m=np.array([(x, y, level * storey_m + CEILING_M) for x, y, level in places]),
        level=np.array([level for _, _, level in places], dtype=np.int64),
        level_at_1m_dbm=rng.normal(POWER_DBM, POWER_SPREAD_DB, count),
        frequency_mhz=rng.choice(np.array(FREQUENCIES_24_MHZ), count),
        bssid=0x00749C000000 + np.arange(count, dtype=np.int64),
        ssid=tuple(f"ap{number}" for number in range(count)),
        radio=np.arange(count, dtype=np.int64),
        long_shadowing=RandomField.draw(rng, count, LONG_SHADOWING_DB, LONG_SHADOWING_M),
        short_shadowing=RandomField.draw(rng, count, SHORT_SHADOWING_DB, SHORT_SHADOWING_M),
    )


def surveyed(world: World, points_m: FloatArray, samples: int, rng: np.random.Generator) -> list[Fingerprint]:
    """What a surveyor hears who stands at every reference point (p, 2), facing east, south, west and north in turn.

    Every sample is a fingerprint; those of one place become one reference point of the map.
    """
    access_points, floor = world.access_points, world.building.floors[0]
    radios, found = len(access_points.level), []
    for number, place in enumerate(floor.to_frame(points_m)):
        near, level = access_points.mean_dbm(floor, np.tile(place, (radios, 1)))
        away = access_points.place_m[near, :2] - place
        bearing = np.arctan2(away[:, 0], away[:, 1])
        facing = 0.5 * np.pi * (1 + np.arange(samples) * 4 // samples)
        behind = 0.5 * (1.0 - np.cos(bearing - facing[:, np.newaxis]))
        heard = level - BODY_LOSS_DB * behind + rng.normal(0.0, FADING_DB, (samples, len(near)))
        heard += rng.normal(0.0, HAND_DB, (samples, 1))
        missed_by = np.clip((HEARING_DBM - heard) / HEARING_WIDTH_DB, -50.0, 50.0)
        caught = (rng.random(heard.shape) < 0.93 / (1.0 + np.exp(missed_by))) & (heard > DEAF_BELOW_DBM)
        for sample in range(samples):
            kept = caught[sample]
            found.append(
                Fingerprint(
                    floor=FLOOR,
                    x_m=float(place[0]),
                    y_m=float(place[1]),
                    time_s=float(sample),
                    walk=f"point {number}",
                    bssid=access_points.bssid[near[kept]],
                    rssi_dbm=np.rint(heard[sample, kept]),
                )
            )
    return found


@dataclass(frozen=True, slots=True)
class Manner:
    """How somebody walks a given route. scan_every_s : None for the usual pauses of a phone.  speed_mps : None for
    the walker's own."""

    rate_hz: float = 50.0
    scan_every_s: float | None = None
    speed_mps: float | None = None
    carrying: Carrying = Carrying.HANDHELD


def walked_along(
    world: World, corners_m: FloatArray, manner: Manner, start_s: float, rng: np.random.Generator
) -> Recording:
    """Somebody new walks along corner points (k, 2) without a pause. The step-length model is trained on them."""
    floor = world.building.floors[0]
    person = replace(Person.draw(rng), pause_share=0.0, bounce=TRAINED_BOUNCE)
    if manner.speed_mps is not None:
        person = replace(person, speed_mps=manner.speed_mps)
    walk = walk_route(floor, floor.to_frame(corners_m), person, start_s, manner.rate_hz, rng)
    feel_rng, scan_rng = rng.spawn(2)
    if manner.carrying is Carrying.HANDHELD:
        inertial = feel(walk, world.disturbance, feel_rng)
    else:
        inertial = feel_carried(walk, manner.carrying, Bearing.draw(feel_rng), world.disturbance, feel_rng)
    scans = scans_along(walk, world.access_points, SURVEY_PHONE.offset_db, scan_rng, manner.scan_every_s)
    return Recording(SURVEY_PHONE, walk, inertial, scans)
