"""The five papers' buildings as rectangles: what each says of its own, and what had to be assumed beside it.

Lengths are metres in the building frame. A way is the list of corner points that every walk of the site goes along.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.estimation.arrays import FloatArray
from app.simulation.layouts import Layout, Rect, Room

Point = tuple[float, float]
PLASTER_DB, BRICK_DB = (2.0, 3.0, 3.0, 4.0), (3.0, 4.0, 5.0, 7.0)


def office_wing(length_m: float, depth_m: float, corridor_m: float, room_m: float) -> Layout:
    """A corridor between two rows of rooms."""
    south, north = depth_m, depth_m + corridor_m
    corridor = Rect(0.0, south, length_m, north)
    hull = Rect(0.0, 0.0, length_m, north + depth_m)
    rooms = []
    for number, x0 in enumerate(np.arange(0.0, length_m - 1e-6, room_m).tolist()):
        x1 = min(x0 + room_m, length_m)
        door_m = (x0 + x1) / 2.0
        rooms.append(Room(f"S{number}", Rect(x0, 0.0, x1, south), Rect(door_m - 0.5, south, door_m + 0.5, south)))
        top = Rect(x0, north, x1, north + depth_m)
        rooms.append(Room(f"N{number}", top, Rect(door_m - 0.5, north, door_m + 0.5, north)))
    return Layout(hull.corners, (corridor,), tuple(rooms), BRICK_DB, 12.0)


def loop(width_m: float, height_m: float, corridor_m: float) -> Layout:
    """A corridor all around a core of rooms."""
    w, h, c = width_m, height_m, corridor_m
    corridors = (Rect(0, 0, w, c), Rect(0, h - c, w, h), Rect(0, c, c, h - c), Rect(w - c, c, w, h - c))
    rooms, middle = [], h / 2.0
    for number, (x0, x1) in enumerate(zip(np.linspace(c, w - c, 5)[:-1], np.linspace(c, w - c, 5)[1:], strict=True)):
        x0, x1, door_m = float(x0), float(x1), float(x0 + x1) / 2.0
        rooms.append(Room(f"S{number}", Rect(x0, c, x1, middle), Rect(door_m - 0.5, c, door_m + 0.5, c)))
        top = Rect(x0, middle, x1, h - c)
        rooms.append(Room(f"N{number}", top, Rect(door_m - 0.5, h - c, door_m + 0.5, h - c)))
    return Layout(Rect(0.0, 0.0, w, h).corners, corridors, tuple(rooms), BRICK_DB, 10.0)


def hall_and_rooms() -> Layout:
    """43.5 x 11.2 m: a corridor along the whole length, a hall and three rooms beside it."""
    c0, c1 = 8.2, 11.2
    hall = Room("hall", Rect(0.0, 0.0, 14.5, c0), Rect(6.0, c0, 9.0, c0))
    rooms = [hall]
    for number, x0 in enumerate((14.5, 24.0, 33.5)):
        x1 = x0 + (9.5 if number < 2 else 10.0)
        door_m = x0 + 2.0
        rooms.append(Room(f"R{number}", Rect(x0, 0.0, x1, c0), Rect(door_m - 0.5, c0, door_m + 0.5, c0)))
    return Layout(Rect(0.0, 0.0, 43.5, c1).corners, (Rect(0.0, c0, 43.5, c1),), tuple(rooms), PLASTER_DB, 10.0)


def three_areas() -> Layout:
    """150 x 50 m: two wings, one above the other, joined by a third at the east end; rooms along the wings."""
    c, depth = 2.4, 7.0
    north, south = Rect(0.0, 40.6, 150.0, 40.6 + c), Rect(55.0, 7.0, 150.0, 7.0 + c)
    link = Rect(150.0 - c, 7.0 + c, 150.0, 40.6)
    rooms = []
    for number, x0 in enumerate(np.arange(0.0, 140.0, 7.5).tolist()):
        for label, corridor in (("C", north), ("B", south)):
            if x0 < corridor.x0 or (label == "B" and x0 > 135.0):
                continue
            door_m = x0 + 3.75
            below = Rect(x0, corridor.y0 - depth, x0 + 7.5, corridor.y0)
            above = Rect(x0, corridor.y1, x0 + 7.5, corridor.y1 + depth)
            rooms.append(Room(f"{label}s{number}", below, Rect(door_m - 0.5, corridor.y0, door_m + 0.5, corridor.y0)))
            rooms.append(Room(f"{label}n{number}", above, Rect(door_m - 0.5, corridor.y1, door_m + 0.5, corridor.y1)))
    hull = Rect(0.0, 0.0, 150.0, 50.0)
    return Layout(hull.corners, (north, south, link), tuple(rooms), BRICK_DB, 9.0)


def teaching_building() -> Layout:
    """24 x 18 m, 430 m2: two corridors that meet, classrooms around."""
    c = 2.6
    along, across = Rect(0.0, 7.0, 24.0, 7.0 + c), Rect(10.0, 7.0 + c, 10.0 + c, 18.0)
    rooms = [
        Room(f"S{k}", Rect(x0, 0.0, x0 + 6.0, 7.0), Rect(x0 + 2.5, 7.0, x0 + 3.5, 7.0))
        for k, x0 in enumerate((0.0, 6.0, 12.0, 18.0))
    ]
    for k, (x0, x1) in enumerate(((0.0, 10.0), (10.0 + c, 24.0))):
        door_m = x0 + 4.0
        rooms.append(Room(f"N{k}", Rect(x0, 7.0 + c, x1, 18.0), Rect(door_m - 0.5, 7.0 + c, door_m + 0.5, 7.0 + c)))
    return Layout(Rect(0.0, 0.0, 24.0, 18.0).corners, (along, across), tuple(rooms), PLASTER_DB, 5.0)


def grid(rects: Sequence[Rect], spacing_m: float) -> FloatArray:
    """Reference points (p, 2): in the middle of every square of a grid that fills the rectangles."""
    points = []
    for rect in rects:
        counts = [max(round((high - low) / spacing_m), 1) for low, high in ((rect.x0, rect.x1), (rect.y0, rect.y1))]
        axes = [
            low + (np.arange(count) + 0.5) * (high - low) / count
            for low, high, count in ((rect.x0, rect.x1, counts[0]), (rect.y0, rect.y1, counts[1]))
        ]
        points.append(np.column_stack([axis.ravel() for axis in np.meshgrid(*axes)]))
    return np.concatenate(points)


def evenly(rect: Rect, columns: int, rows: int, levels: Sequence[int] = (0,)) -> list[tuple[float, float, int]]:
    """Access points evenly over a rectangle, on every level."""
    return [(float(x), float(y), level) for level in levels for x, y in _cells(rect, columns, rows)]


def along_sides(corridors: Sequence[Rect], count: int) -> list[tuple[float, float, int]]:
    """So many access points on both walls of corridors, evenly over their whole length."""
    total_m = sum(max(r.x1 - r.x0, r.y1 - r.y0) for r in corridors)
    places = []
    for number in range(count // 2):
        rest_m = (number + 0.5) * total_m / (count // 2)
        for r in corridors:
            length_m = max(r.x1 - r.x0, r.y1 - r.y0)
            if rest_m <= length_m:
                if r.x1 - r.x0 >= r.y1 - r.y0:
                    places += [(r.x0 + rest_m, r.y0 + 0.2, 0), (r.x0 + rest_m, r.y1 - 0.2, 0)]
                else:
                    places += [(r.x0 + 0.2, r.y0 + rest_m, 0), (r.x1 - 0.2, r.y0 + rest_m, 0)]
                break
            rest_m -= length_m
    return places


def _cells(rect: Rect, columns: int, rows: int) -> list[Point]:
    width_m, height_m = (rect.x1 - rect.x0) / columns, (rect.y1 - rect.y0) / rows
    return [
        (rect.x0 + (i + 0.5) * width_m, rect.y0 + (j + 0.5) * height_m) for j in range(rows) for i in range(columns)
    ]
