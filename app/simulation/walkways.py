"""Where one can walk: places joined by straight lines that cross no wall, and random routes through them.

A place is a rectangle, and joined places lie in one room or corridor, which is convex: any point of the one sees any
point of the other. So a route is drawn afresh inside the places each time, and walkers do not all keep to the middle.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from app.estimation.arrays import BoolArray, FloatArray, IntArray
from app.simulation.layouts import Layout, Rect

CLEARANCE_M = 0.5
"""People keep off walls by this much."""


@dataclass(frozen=True, slots=True, eq=False)
class Walkways:
    """Places (n, 4) as x0, y0, x1, y1 in the building frame, the walking distances between them (n, n), the place
    before the last on the way (n, n), and which are worth going to (n,)."""

    places: FloatArray
    distance_m: FloatArray
    before: IntArray
    goal: BoolArray

    @classmethod
    def of(cls, layout: Layout) -> Walkways:
        """The walkways of a floor: junctions of corridors, doors with the spot before them, rooms."""
        places: list[Rect] = []
        pairs: list[tuple[int, int]] = []
        on_corridor: list[list[int]] = [[] for _ in layout.corridors]
        goals = []

        def add(place: Rect) -> int:
            places.append(place)
            return len(places) - 1

        for i, corridor in enumerate(layout.corridors):
            for j in range(i):
                part = corridor.meet(layout.corridors[j])
                if part is not None:
                    junction = add(part.shrunk(CLEARANCE_M))
                    on_corridor[i].append(junction)
                    on_corridor[j].append(junction)
        for room in layout.rooms:
            i = next(k for k, c in enumerate(layout.corridors) if _touches(room.door, c))
            front = add(_front(room.door, layout.corridors[i]))
            door, inside = add(room.door.shrunk(0.4)), add(room.area.shrunk(1.0))
            pairs += [(front, door), (door, inside)]
            on_corridor[i].append(front)
            goals.append(inside)
        for corridor, members in zip(layout.corridors, on_corridor, strict=True):
            along = 0 if corridor.x1 - corridor.x0 >= corridor.y1 - corridor.y0 else 1
            ordered = sorted(members, key=lambda m, a=along: places[m].centre[a])  # type: ignore[misc]
            pairs += pairwise(ordered)
            goals += ordered[:1] + ordered[-1:]
        return cls._joined(places, pairs, goals)

    @classmethod
    def _joined(cls, places: list[Rect], pairs: list[tuple[int, int]], goals: list[int]) -> Walkways:
        centres = np.array([p.centre for p in places])
        one, other = np.array(pairs).T
        length = np.linalg.norm(centres[one] - centres[other], axis=1) + 0.01
        graph = csr_matrix((length, (one, other)), shape=(len(places), len(places)))
        count, _ = connected_components(graph, directed=False)
        if count != 1:
            raise ValueError(f"the layout falls into {count} parts that no door joins")
        distance, before = dijkstra(graph, directed=False, return_predecessors=True)
        goal = np.zeros(len(places), dtype=np.bool_)
        goal[goals] = True
        boxes = np.array([(p.x0, p.y0, p.x1, p.y1) for p in places])
        return cls(boxes, distance, before.astype(np.int64), goal)

    def route(self, rng: np.random.Generator, length_m: float, near: FloatArray | None = None) -> FloatArray:
        """Corner points (k, 2) of a way from one random goal to the next, cut off at length_m.

        near : (2,) where it begins, or as near as a place is; by default at a random goal.
        """
        goals = np.flatnonzero(self.goal)
        if near is None:
            here = int(rng.choice(goals))
        else:
            centres = (self.places[:, :2] + self.places[:, 2:]) / 2.0
            here = int(np.linalg.norm(centres - near, axis=1).argmin())
        points = [self._point(rng, here)]
        walked = 0.0
        while walked < length_m:
            away = self.distance_m[here, goals]
            there = int(rng.choice(goals[(away > 6.0) & (away < max(60.0, away[away > 6.0].min() + 1.0))]))
            for place in self._way(here, there):
                point = self._point(rng, place)
                step = float(np.hypot(*(point - points[-1])))
                if walked + step > length_m:
                    point = points[-1] + (point - points[-1]) * (length_m - walked) / step
                if step > 0.05:
                    points.append(point)
                walked += step
                if walked >= length_m:
                    break
            here = there
        return np.array(points)

    def _way(self, here: int, there: int) -> list[int]:
        way = [there]
        while int(self.before[here, way[-1]]) != here:
            way.append(int(self.before[here, way[-1]]))
        return way[::-1]

    def _point(self, rng: np.random.Generator, place: int) -> FloatArray:
        x0, y0, x1, y1 = self.places[place]
        return np.array([rng.uniform(x0, x1), rng.uniform(y0, y1)])


def _touches(door: Rect, corridor: Rect) -> bool:
    part = door.meet(corridor)
    return part is not None and max(part.x1 - part.x0, part.y1 - part.y0) > 0.5


def _front(door: Rect, corridor: Rect) -> Rect:
    """The part of the corridor across from a door."""
    if door.y0 == door.y1:
        return Rect(door.x0, corridor.y0, door.x1, corridor.y1).shrunk(CLEARANCE_M)
    return Rect(corridor.x0, door.y0, corridor.x1, door.y1).shrunk(CLEARANCE_M)
