"""People: how fast they walk, where they turn and stop, and when each step falls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from app.estimation.arrays import FloatArray
from app.simulation.building import SimulatedFloor

SPACING_M = 0.02
"""Of the points along the path on which speed is laid out."""
CORNER_M = 0.35
"""How widely corners are rounded."""
TURN_RAD = 0.6
"""A bend that a surveyor marks with a waypoint."""


@dataclass(frozen=True, slots=True)
class Person:
    """A walker's habits. bounce is the constant that ties step length to the size of the acceleration's swing."""

    speed_mps: float
    step_hz: float
    bounce: float
    pause_share: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Person:
        """Someone like the surveyors of the open data: 1.1 m/s with all stops and bends, 1.85 steps a second."""
        return cls(
            speed_mps=float(np.clip(rng.normal(1.32, 0.14), 0.9, 1.7)),
            step_hz=float(np.clip(rng.normal(1.88, 0.09), 1.55, 2.2)),
            bounce=float(rng.normal(0.372, 0.025)),
            pause_share=float(rng.uniform(0.0, 0.25)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """The truth of a walk, in its floor's frame, sampled at the sensors' rate.

    time_s : (n,) Unix.  xy_m : (n, 2).  heading_rad : (n,) direction of the body, not wrapped.  speed_mps : (n,).
    step_phase : (n,) steps taken so far, with fraction.  waypoint_time_s : (w,).  waypoint_xy_m : (w, 2).
    climbed_m : (n,) above the floor, None of who stays on it.  other_floors : that are changed to (climb.py).
    """

    floor: SimulatedFloor
    person: Person
    time_s: FloatArray
    xy_m: FloatArray
    heading_rad: FloatArray
    speed_mps: FloatArray
    step_phase: FloatArray
    waypoint_time_s: FloatArray
    waypoint_xy_m: FloatArray
    climbed_m: FloatArray | None = None
    other_floors: tuple[SimulatedFloor, ...] = ()

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return float((len(self.time_s) - 1) / (self.time_s[-1] - self.time_s[0]))

    @property
    def height_m(self) -> FloatArray:
        """(n,) of the feet above the ground floor."""
        climbed_m = np.zeros(len(self.time_s)) if self.climbed_m is None else self.climbed_m
        return climbed_m + self.floor.level * self.floor.storey_height_m

    def floor_at(self, time_s: float) -> SimulatedFloor:
        """The floor that the walker is on or, between two, nearest to."""
        if not self.other_floors:
            return self.floor
        height_m = np.interp(time_s, self.time_s, self.height_m)
        floors = (self.floor, *self.other_floors)
        return min(floors, key=lambda floor: abs(floor.level * floor.storey_height_m - height_m))

    def moved_m(self, from_s: float, to_s: float) -> float:
        """How far apart the places at two times are."""
        axes = (*self.xy_m.T, self.height_m)
        here, there = (np.array([np.interp(t, self.time_s, axis) for axis in axes]) for t in (from_s, to_s))
        return float(np.linalg.norm(there - here))


def walk_route(
    floor: SimulatedFloor,
    corners_m: FloatArray,
    person: Person,
    start_s: float,
    rate_hz: float,
    rng: np.random.Generator,
) -> Walk:
    """Walk along corner points (k, 2) from start_s on.

    Speed falls before bends and rises after them, varies slowly by itself, and is zero in the pauses at some waypoints.
    """
    path, along = _rounded(corners_m)
    step = np.gradient(path, axis=0)
    heading = np.unwrap(np.arctan2(step[:, 0], step[:, 1]))
    marks = _marks(along, heading, rng)

    bend = np.abs(np.gradient(gaussian_filter1d(heading, 0.3 / SPACING_M), along))
    speed = person.speed_mps / (1.0 + 0.55 * bend) * np.exp(_slow_noise(rng, len(along), 4.0 / SPACING_M, 0.07))
    edge = np.minimum(along - along[0], along[-1] - along)
    speed *= np.clip(0.35 + edge / 0.8, 0.0, 1.0)
    stops = {int(m): float(rng.uniform(1.5, 7.0)) for m in marks[1:-1] if rng.random() < person.pause_share}
    for mark in stops:
        speed *= np.clip(0.3 + np.abs(along - along[mark]) / 0.6, 0.0, 1.0)
    passing_s = np.concatenate([[0.0], np.cumsum(np.diff(along) / ((speed[1:] + speed[:-1]) / 2))])
    leaving_s = passing_s.copy()
    for mark, seconds in stops.items():
        passing_s[mark + 1 :] += seconds
        leaving_s[mark:] += seconds

    clock = np.arange(0.0, passing_s[-1], 1.0 / rate_hz)
    knots = np.concatenate([passing_s, leaving_s[list(stops)]])
    order = np.argsort(knots, kind="stable")
    place = np.concatenate([along, along[list(stops)]])[order]
    done_m = np.interp(clock, knots[order], place)
    now_mps = np.gradient(done_m, clock)
    cadence_hz = person.step_hz * (np.maximum(now_mps, 0.0) / person.speed_mps) ** 0.25
    cadence_hz[now_mps < 0.15] = 0.0
    return Walk(
        floor=floor,
        person=person,
        time_s=start_s + clock,
        xy_m=np.column_stack([np.interp(done_m, along, path[:, axis]) for axis in (0, 1)]),
        heading_rad=np.interp(done_m, along, gaussian_filter1d(heading, 0.15 / SPACING_M)),
        speed_mps=now_mps,
        step_phase=np.cumsum(cadence_hz) / rate_hz,
        # a paused surveyor marks the point on arrival or when walking on, as people do
        waypoint_time_s=start_s
        + np.array([passing_s[m] + stops.get(int(m), 0.0) * rng.uniform() for m in marks[:-1]] + [clock[-1]]),
        waypoint_xy_m=path[marks],
    )


def _rounded(corners_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points SPACING_M apart along the corner points, corners rounded, and the way to each."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners_m, axis=0), axis=1))])
    even = np.linspace(0.0, way[-1], max(int(way[-1] / SPACING_M), 50))
    straight = np.column_stack([np.interp(even, way, corners_m[:, axis]) for axis in (0, 1)])
    path = gaussian_filter1d(straight, CORNER_M / SPACING_M, axis=0, mode="nearest")
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    keep = np.concatenate([[True], np.diff(along) > 1e-6])
    return path[keep], along[keep]


def _marks(along: FloatArray, heading: FloatArray, rng: np.random.Generator) -> list[int]:
    """Where a surveyor sets waypoints: at bends and, on long straights, every few metres."""
    marks, last_heading = [0], heading[0]
    patience = float(rng.uniform(5.0, 16.0))
    for i in range(0, len(along), 10):
        since = along[i] - along[marks[-1]]
        turned = abs(heading[i] - last_heading) > TURN_RAD
        if along[-1] - along[i] > 1.5 and ((turned and since > 2.5) or since > patience):
            marks.append(i)
            last_heading, patience = heading[i], float(rng.uniform(5.0, 16.0))
    return [*marks, len(along) - 1]


def _slow_noise(rng: np.random.Generator, count: int, scale: float, sigma: float) -> FloatArray:
    """Smooth noise (count,) that changes over `scale` samples, of standard deviation sigma."""
    knots = rng.normal(0.0, sigma, max(int(count / scale), 1) + 3)
    return np.interp(np.arange(count) / scale, np.arange(len(knots)), knots)
