"""A simulated office, its radio map, and phones that are carried through it or left lying there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.estimation.arrays import FloatArray
from app.evaluation.truth import batches_of, places_at
from app.fusion.interface import Floor, Method, SessionStart, Site
from app.observations import AxisSamples, Batch, Fix, WifiScan
from app.simulation.imu import feel
from app.simulation.recording import SURVEY_PHONE, Recording, World, make_world, record_walk
from app.simulation.trace_writer import trace_bytes
from app.simulation.walker import Person, Walk
from app.simulation.wifi_scanner import scans_along
from app.survey.trace import Trace, read_trace
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import build_radio_map

START_S = 1_700_000_000.0
RATE_HZ = 50.0
SPACING_M = 3.0
HEARD_ABOVE_DBM = -86.0
STREAMS = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


@dataclass(frozen=True)
class Walked:
    """One walk: its batches of a second, and the truth."""

    trace: Trace
    batches: tuple[Batch, ...]

    def truth(self, time_s: float) -> FloatArray:
        """(2,) where the walker was."""
        return np.asarray(places_at(self.trace, np.array([time_s]))[0])


@lru_cache
def world() -> World:
    return make_world("office", "office", 2, seed=11)


@lru_cache
def site(surveyed_from_m: float = 0.0) -> Site:
    """Every floor surveyed on a grid, each place as it sounds on average; nothing west of where surveyors began."""
    points, floors = world().access_points, world().building.floors
    surveyed = []
    for floor in floors:
        for x_m in np.arange(surveyed_from_m + 1.0, floor.width_m, SPACING_M):
            for y_m in np.arange(1.0, floor.height_m, SPACING_M):
                radio, level_dbm = points.mean_dbm(floor, np.tile([x_m, y_m], (len(points.level), 1)))
                level = np.full(len(points.level), -200.0)
                level[radio] = level_dbm
                heard = level[points.radio]
                loud = heard > HEARD_ABOVE_DBM
                if loud.any():
                    surveyed.append(
                        Fingerprint(floor.floor, float(x_m), float(y_m), 0.0, "survey", points.bssid[loud], heard[loud])
                    )
    described = {one.floor: Floor(one.floor, one.level, one.width_m, one.height_m) for one in floors}
    return Site(described, build_radio_map(surveyed, cell_m=0.0))


@lru_cache
def walked(seed: int = 5, length_m: float = 90.0, start_s: float = START_S, level: int = 0) -> Walked:
    """Somebody's random walk."""
    rng = np.random.default_rng(seed)
    floor = world().building.floors[level]
    return _of(record_walk(world(), floor, SURVEY_PHONE, start_s, length_m, RATE_HZ, rng))


@lru_cache
def lying(seconds: float = 90.0, seed: int = 3) -> Walked:
    """A phone that lies on a table in the middle of a corridor."""
    rng = np.random.default_rng(seed)
    floor = world().building.floors[0]
    place = floor.route(rng, 20.0)[0]
    time_s = START_S + np.arange(0.0, seconds, 1.0 / RATE_HZ)
    nothing = np.zeros(len(time_s))
    walk = Walk(
        floor=floor,
        person=Person(0.0, 1.8, 0.37, 0.0),
        time_s=time_s,
        xy_m=np.tile(place, (len(time_s), 1)),
        heading_rad=nothing,
        speed_mps=nothing,
        step_phase=nothing,
        waypoint_time_s=time_s[[0, -1]],
        waypoint_xy_m=np.tile(place, (2, 1)),
    )
    feel_rng, scan_rng = rng.spawn(2)
    scans = scans_along(walk, world().access_points, 0.0, scan_rng)
    return _of(Recording(SURVEY_PHONE, walk, feel(walk, world().disturbance, feel_rng), scans))


def _of(recording: Recording) -> Walked:
    trace = read_trace(trace_bytes(recording, world().access_points, "office"), "walk.txt")
    return Walked(trace, tuple(batches_of(trace, 1.0)))


def run(
    method: Method, batches: tuple[Batch, ...] | list[Batch], on: Site | None = None, start: SessionStart | None = None
) -> list[Fix]:
    """The answers to a series of batches."""
    state, fixes = method.start(start or SessionStart()), []
    for batch in batches:
        state, fix = method.advance(state, batch, on or site())
        fixes.append(fix)
    return fixes


def errors_m(walk: Walked, fixes: list[Fix]) -> FloatArray:
    """(n,) of the Fixes that have a position, in order."""
    placed = [fix for fix in fixes if fix.position is not None and fix.time_s is not None]
    found = np.array([(fix.position.x_m, fix.position.y_m) for fix in placed if fix.position])
    truth = places_at(walk.trace, np.array([fix.time_s for fix in placed]))
    return np.asarray(np.hypot(*(found - truth).T))


def places_m(fixes: list[Fix]) -> FloatArray:
    """(n, 2) positions of the Fixes that have one."""
    return np.array([(fix.position.x_m, fix.position.y_m) for fix in fixes if fix.position is not None])


def without(batch: Batch, *streams: str) -> Batch:
    """The batch of a phone that lacks these sensors."""
    return replace(batch, **{name: AxisSamples() for name in streams})  # type: ignore[arg-type]


def deaf(batch: Batch) -> Batch:
    """The batch of a phone that hears no access point."""
    return replace(batch, wifi=())


def strange(batch: Batch) -> Batch:
    """The batch with every access point renamed to one that no map knows."""
    scans = tuple(WifiScan(s.time_s, s.bssid + (1 << 47), s.rssi_dbm, s.seen_s) for s in batch.wifi)
    return replace(batch, wifi=scans)
