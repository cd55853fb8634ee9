"""GIVEN a surveyed building WHEN phones walk through it THEN only what has changed since is to be surveyed again.

Phones are placed where they are, to a few metres: what their sessions make of the radio is not what is tested here.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.interface import Site
from app.fusion.scan_matching import Matcher, match_scan
from app.observations import Carrying, Fix, Flag, Integrity, Motion, Position, RadioFix, WifiScan
from app.services.map_drift import JudgedSquare, MapDrift
from app.services.map_use import MapUse
from app.simulation.access_points import AccessPoints
from app.simulation.recording import VISITOR_PHONES, World, make_world
from app.simulation.walker import Person, walk_route
from app.simulation.wifi_scanner import scans_along
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.readings import FRESH_S
from app.wifi.survey_likeness import CELL_M, stored_likeness
from tests.services.test_map_use import Rows

SEED, SURVEY_WALKS, SESSIONS = 23, 80, 60
PLACED_M = 3.0
CORNER = 0.45
"""Of width and height: there every access point is replaced."""


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """A scan of a walk, and where it was taken."""

    scan: WifiScan
    xy_m: FloatArray


@cache
def world() -> World:
    return make_world("drift", "office", 1, SEED)


def walked(access_points: AccessPoints, number: int, offset_db: float, start_s: float) -> Iterator[Heard]:
    """Somebody walks a random route of 20 to 95 m; readings that are not fresh are left out."""
    rng = np.random.default_rng([SEED, number])
    floor = world().building.floors[0]
    route = floor.route(rng, float(np.exp(rng.uniform(*np.log((20.0, 95.0))))))
    walk = walk_route(floor, route, Person.draw(rng), start_s, 10.0, rng)
    for one in scans_along(walk, access_points, offset_db, rng):
        fresh = one.seen_ms >= one.time_ms - 1000.0 * FRESH_S
        network, first = np.unique(one.network[fresh], return_index=True)
        time_s = one.time_ms / 1000.0
        bssid, rssi_dbm = access_points.bssid[network], one.rssi_dbm[fresh][first].astype(np.float64)
        order = np.argsort(bssid)
        scan = WifiScan(time_s, bssid[order], rssi_dbm[order], np.full(len(order), time_s))
        yield Heard(scan, np.array([np.interp(time_s, walk.time_s, axis) for axis in walk.xy_m.T]))


@cache
def site() -> Site:
    survey = [
        Fingerprint(
            floor="F1",
            x_m=float(one.xy_m[0]),
            y_m=float(one.xy_m[1]),
            time_s=one.scan.time_s,
            walk=f"walk {number}",
            bssid=one.scan.bssid,
            rssi_dbm=one.scan.rssi_dbm,
        )
        for number in range(SURVEY_WALKS)
        for one in walked(world().access_points, number, 0.0, 1.7e9 + 1000.0 * number)
    ]
    return Site(radio_map=calibrated_map(survey, version=1))


def replaced_in_the_corner() -> AccessPoints:
    """The same building with other access points in one corner."""
    access_points, floor = world().access_points, world().building.floors[0]
    size_m = np.array([floor.width_m, floor.height_m])
    new = np.all(access_points.place_m[:, :2] < CORNER * size_m, axis=1).reshape(-1)
    assert 5 < new.sum() < 0.4 * len(new)
    bssid = np.where(new[access_points.radio], access_points.bssid ^ 0x5A5A5A, access_points.bssid)
    return replace(access_points, bssid=bssid)


def drift_after(access_points: AccessPoints, sessions: int) -> MapDrift:
    """What the use of so many sessions says; every fourth is of one of four phones."""
    radio_map = site().radio_map
    assert radio_map is not None
    likeness = stored_likeness(radio_map.sections)
    assert likeness is not None
    counter = MapUse(Rows(), lambda: 1_700_000_000_000)

    async def use() -> MapDrift:
        for number in range(sessions):
            offset_db = VISITOR_PHONES[number % len(VISITOR_PHONES)].offset_db
            rng = np.random.default_rng([SEED, 7, number])
            for one in walked(access_points, 1000 + number, offset_db, 1.71e9 + 1000.0 * number):
                match = match_scan(radio_map, one.scan, Matcher.SOFT, 3)
                if match is not None:
                    placed_m = one.xy_m + rng.normal(0.0, PLACED_M, 2)
                    await counter.heard(
                        "office", site(), f"session {number}", "surefix", fix(placed_m, match.signal_distance)
                    )
        await counter.close()
        return await counter.drift("office", 1, likeness, radio_map.floors)

    return asyncio.run(use())


def fix(xy_m: FloatArray, signal_distance: float) -> Fix:
    said = RadioFix(0.0, "F1", xy_m, np.eye(2), 1.0, signal_distance, fits=True)
    integrity = Integrity(Flag.NOMINAL, True, 0, 0, 0, None, None, 9.0, 10.0, 0.01)
    position = Position(float(xy_m[0]), float(xy_m[1]), "F1")
    unknown = (None, None, None, None)
    return Fix(0.0, position, *unknown, 0, Motion.WALKING, Carrying.UNKNOWN, integrity, (), (said,))


def in_the_corner(square: JudgedSquare) -> bool:
    """Or at its edge, where what was replaced is still heard."""
    floor = world().building.floors[0]
    return square.x_m < CORNER * floor.width_m + CELL_M and square.y_m < CORNER * floor.height_m + CELL_M


def test_a_building_that_has_not_changed_is_not_to_be_surveyed_again_anywhere() -> None:
    drift = drift_after(world().access_points, SESSIONS)
    assert len(drift.judged) > 10
    assert drift.resurvey == ()
    assert drift.ratio is not None and 0.7 < drift.ratio < 1.1


def test_the_corner_whose_access_points_were_replaced_is_found_and_nothing_else_is() -> None:
    found = {sessions: drift_after(replaced_in_the_corner(), sessions).resurvey for sessions in (15, 30, SESSIONS)}
    assert all(in_the_corner(square) for squares in found.values() for square in squares)
    assert len(found[15]) <= len(found[30]) <= len(found[SESSIONS])
    assert len(found[30]) >= 2 and len(found[SESSIONS]) >= 6
