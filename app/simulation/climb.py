"""Walks over several floors: on each floor a route, from one to the next by stairs or lift.

Stairs and lifts are not drawn in the layouts. They are where a route happens to end, and the next begins at the nearest
place of the other floor.
"""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum
from itertools import pairwise

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.simulation.building import Building
from app.simulation.walker import Person, Walk, walk_route

STAIRS_MPS = 0.19
"""Upwards: a storey of 3.6 m takes 19 s."""
FLIGHT_M, EFFORT = 3.2, 0.75
"""Length of a flight in plan; two, one back, are a storey. On stairs steps are felt like those of a slower walk."""
LIFT_MPS, LIFT_MPS2 = 1.5, 0.8
WAIT_S, TURN_S = 4.0, 1.5
"""Before and after a ride, and for turning to the stairs."""


class Climbing(StrEnum):
    """How a walker gets to another floor."""

    STAIRS = "stairs"
    LIFT = "lift"


def climb(
    building: Building,
    levels: tuple[int, ...],
    how: Climbing,
    person: Person,
    start_s: float,
    length_m: float,
    rate_hz: float,
    rng: np.random.Generator,
) -> Walk:
    """About length_m on each of the levels (from 0) in turn. All floors lie in one frame."""
    floors = [building.floors[level] for level in levels]
    others = tuple(floor for floor in building.floors if floor is not floors[0])
    walk = walk_route(floors[0], floors[0].route(rng, length_m), person, start_s, rate_hz, rng)
    walk = replace(walk, climbed_m=np.zeros(len(walk.time_s)), other_floors=others)
    for here, there in pairwise(floors):
        x_m, y_m = walk.xy_m[-1].tolist()
        route = there.route(rng, length_m, (x_m, y_m))
        rise_m = there.level * there.storey_height_m - here.level * here.storey_height_m
        walk = _joined(walk, _passage(walk, route[0], rise_m, how, rate_hz))
        walk = _joined(walk, walk_route(there, route, person, 0.0, rate_hz, rng))
    return walk


def _passage(walk: Walk, to_m: FloatArray, rise_m: float, how: Climbing, rate_hz: float) -> Walk:
    """From the end of a walk to a place on another floor; its climbed_m begins at 0."""
    storeys = max(round(abs(rise_m) / walk.floor.storey_height_m), 1)
    if how is Climbing.STAIRS:
        seconds, speed_mps, hertz = abs(rise_m) / STAIRS_MPS, EFFORT * walk.person.speed_mps, 0.9 * walk.person.step_hz
        time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
        done = time_s / seconds
    else:
        seconds, speed_mps, hertz = ride_s(abs(rise_m)) + 2.0 * WAIT_S, 0.0, 0.0
        time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
        done = _ridden_m(time_s - WAIT_S, abs(rise_m)) / abs(rise_m)
    away = np.array([math.sin(walk.heading_rad[-1]), math.cos(walk.heading_rad[-1])])
    # flights lead away and back, and the rest of the way is made in between
    aside_m = (
        FLIGHT_M * (1.0 - np.abs(1.0 - 2.0 * np.mod(done * storeys, 1.0))) if how is Climbing.STAIRS else 0.0 * done
    )
    xy_m = walk.xy_m[-1] + done[:, np.newaxis] * (to_m - walk.xy_m[-1]) + aside_m[:, np.newaxis] * away
    turned = np.where(np.mod(done * storeys, 1.0) < 0.5, 0.0, math.pi) if how is Climbing.STAIRS else 0.0 * done
    return replace(
        walk,
        time_s=time_s,
        xy_m=xy_m,
        heading_rad=walk.heading_rad[-1] + _smooth(turned, 0.6 * rate_hz),
        speed_mps=np.full(len(time_s), speed_mps),
        step_phase=hertz * time_s,
        waypoint_time_s=np.empty(0),
        waypoint_xy_m=np.empty((0, 2)),
        climbed_m=rise_m * done,
    )


def ride_s(rise_m: float) -> float:
    """How long a lift takes from halt to halt."""
    to_full_m = LIFT_MPS**2 / LIFT_MPS2
    if rise_m < to_full_m:
        return 2.0 * math.sqrt(rise_m / LIFT_MPS2)
    return (rise_m - to_full_m) / LIFT_MPS + 2.0 * LIFT_MPS / LIFT_MPS2


def _ridden_m(time_s: FloatArray, rise_m: float) -> FloatArray:
    """(n,) how far a lift has come so long after it set off."""
    whole_s = ride_s(rise_m)
    peak_mps = min(LIFT_MPS, LIFT_MPS2 * whole_s / 2.0)
    now_s = np.clip(time_s, 0.0, whole_s)
    early, late = np.minimum(now_s, peak_mps / LIFT_MPS2), np.minimum(whole_s - now_s, peak_mps / LIFT_MPS2)
    cruise_s = np.clip(now_s - peak_mps / LIFT_MPS2, 0.0, whole_s - 2.0 * peak_mps / LIFT_MPS2)
    slowing_m = 0.5 * LIFT_MPS2 * ((peak_mps / LIFT_MPS2) ** 2 - late**2)
    return np.asarray(0.5 * LIFT_MPS2 * early**2 + peak_mps * cruise_s + slowing_m, dtype=np.float64)


def _smooth(values: FloatArray, width: float) -> FloatArray:
    window = np.ones(max(int(width), 1)) / max(int(width), 1)
    padded = np.pad(values, len(window), mode="edge")
    return np.convolve(padded, window, mode="same")[len(window) : -len(window)]


def _joined(first: Walk, second: Walk) -> Walk:
    """One walk after the other: whoever arrives stands a moment and turns to where the way goes on."""
    pause_s = np.arange(first.time_s[1] - first.time_s[0], TURN_S, first.time_s[1] - first.time_s[0])
    count = len(pause_s)
    turn_rad = wrap(float(second.heading_rad[0] - first.heading_rad[-1]))
    share = np.linspace(0.0, 1.0, count)
    begin_s = float(first.time_s[-1] + pause_s[-1] + pause_s[0])
    later = begin_s - float(second.time_s[0])
    climbed_m = first.height_m - first.floor.level * first.floor.storey_height_m
    added_m = np.zeros(len(second.time_s)) if second.climbed_m is None else second.climbed_m
    heading_rad = second.heading_rad - second.heading_rad[0] + first.heading_rad[-1] + turn_rad
    return replace(
        first,
        time_s=np.concatenate([first.time_s, first.time_s[-1] + pause_s, second.time_s + later]),
        xy_m=np.vstack(
            [first.xy_m, first.xy_m[-1] + share[:, np.newaxis] * (second.xy_m[0] - first.xy_m[-1]), second.xy_m]
        ),
        heading_rad=np.concatenate([first.heading_rad, first.heading_rad[-1] + share * turn_rad, heading_rad]),
        speed_mps=np.concatenate([first.speed_mps, np.zeros(count), second.speed_mps]),
        step_phase=np.concatenate(
            [first.step_phase, np.full(count, first.step_phase[-1]), second.step_phase + first.step_phase[-1]]
        ),
        waypoint_time_s=np.concatenate([first.waypoint_time_s, second.waypoint_time_s + later]),
        waypoint_xy_m=np.vstack([first.waypoint_xy_m, second.waypoint_xy_m]),
        climbed_m=np.concatenate([climbed_m, np.full(count, climbed_m[-1]), climbed_m[-1] + added_m]),
    )
