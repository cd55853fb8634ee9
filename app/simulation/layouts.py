"""Floor layouts from rectangles: an office, a mall and a hospital, with random rooms.

Every layout is made of one part, a row of rooms along a corridor; the kinds differ in sizes, materials and outline.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True, slots=True)
class Rect:
    """An axis-parallel rectangle in the building frame, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    def meet(self, other: Rect) -> Rect | None:
        """The common part, possibly only an edge; None where they are apart."""
        part = Rect(max(self.x0, other.x0), max(self.y0, other.y0), min(self.x1, other.x1), min(self.y1, other.y1))
        return part if part.x0 <= part.x1 and part.y0 <= part.y1 else None

    def shrunk(self, margin_m: float) -> Rect:
        """The rectangle without a margin; what is too narrow shrinks to its centre line."""
        x, y = self.centre
        return Rect(
            min(self.x0 + margin_m, x),
            min(self.y0 + margin_m, y),
            max(self.x1 - margin_m, x),
            max(self.y1 - margin_m, y),
        )

    @property
    def centre(self) -> tuple[float, float]:
        """Middle point."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Four corners, counter-clockwise."""
        return (self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)


@dataclass(frozen=True, slots=True)
class Room:
    """A room with one door, given as the gap it makes in the wall (a degenerate rectangle)."""

    name: str
    area: Rect
    door: Rect


@dataclass(frozen=True, slots=True)
class Layout:
    """A floor's geometry. outline : counter-clockwise corners. wall_losses_db : what inner walls may cost a signal."""

    outline: tuple[tuple[float, float], ...]
    corridors: tuple[Rect, ...]
    rooms: tuple[Room, ...]
    wall_losses_db: tuple[float, ...]
    access_point_spacing_m: float


def _row(rng: np.random.Generator, strip: Rect, door_side: str, room_m: float, door_m: float, label: str) -> list[Room]:
    """Rooms of about room_m along a strip, doors towards door_side (north, south, east or west)."""
    along_x = door_side in ("north", "south")
    begin, end = (strip.x0, strip.x1) if along_x else (strip.y0, strip.y1)
    shares = rng.uniform(0.6, 1.6, max(1, round((end - begin) / room_m)))
    cuts = begin + (end - begin) * np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
    wall = {"north": strip.y1, "south": strip.y0, "east": strip.x1, "west": strip.x0}[door_side]
    rooms: list[Room] = []
    for low, high in pairwise(cuts.tolist()):
        width = min(door_m, 0.8 * (high - low))
        gap = float(rng.uniform(low + 0.05 * (high - low), high - 0.05 * (high - low) - width))
        if along_x:
            area, door = Rect(low, strip.y0, high, strip.y1), Rect(gap, wall, gap + width, wall)
        else:
            area, door = Rect(strip.x0, low, strip.x1, high), Rect(wall, gap, wall, gap + width)
        rooms.append(Room(f"{label}{len(rooms) + 1:02d}", area, door))
    return rooms


def _banded(
    rng: np.random.Generator,
    width_m: float,
    outer_depth_m: float,
    corridor_m: float,
    core_depths_m: tuple[float, ...],
    crossing_count: int,
    room_m: float,
    door_m: float,
) -> tuple[Rect, tuple[Rect, ...], tuple[Room, ...]]:
    """Parallel corridors with rooms outside, cores of two rows between them, and cross corridors through the cores."""
    rooms = _row(rng, Rect(0.0, 0.0, width_m, outer_depth_m), "north", room_m, door_m, "S")
    y = outer_depth_m
    corridors = [Rect(0.0, y, width_m, y + corridor_m)]
    ends = np.linspace(0.0, width_m - corridor_m, crossing_count)
    ends[1:-1] += rng.uniform(-0.08, 0.08, crossing_count - 2) * width_m
    for band, depth in enumerate(core_depths_m):
        y += corridor_m
        corridors += [Rect(west, y, west + corridor_m, y + depth) for west in ends.tolist()]
        for block, (west, east) in enumerate(pairwise(ends.tolist())):
            middle = y + depth * float(rng.uniform(0.4, 0.6))
            label = f"{'ABCDEFGH'[band]}{block + 1}"
            rooms += _row(rng, Rect(west + corridor_m, y, east, middle), "south", room_m, door_m, f"{label}s")
            rooms += _row(rng, Rect(west + corridor_m, middle, east, y + depth), "north", room_m, door_m, f"{label}n")
        y += depth
        corridors.append(Rect(0.0, y, width_m, y + corridor_m))
    y += corridor_m
    rooms += _row(rng, Rect(0.0, y, width_m, y + outer_depth_m), "south", room_m, door_m, "N")
    return Rect(0.0, 0.0, width_m, y + outer_depth_m), tuple(corridors), tuple(rooms)


def office(rng: np.random.Generator) -> Layout:
    """Two corridors around a core, 66 x 39 m, small rooms."""
    hull, corridors, rooms = _banded(rng, 66.0, 7.0, 2.4, (20.0,), 3, 5.0, 1.0)
    return Layout(hull.corners, corridors, rooms, (2.0, 3.0, 3.0, 4.0, 7.0), 14.0)


def mall(rng: np.random.Generator) -> Layout:
    """Three wide malls between rows of open shops, 140 x 103 m."""
    hull, corridors, rooms = _banded(rng, 140.0, 16.0, 7.0, (24.0, 26.0), 4, 12.0, 4.0)
    return Layout(hull.corners, corridors, rooms, (0.5, 1.0, 2.0, 3.0, 6.0), 17.0)


def hospital(rng: np.random.Generator) -> Layout:
    """A spine with three wings and courts between them, 100 x 54 m."""
    width, base, spine, wing_depth, aisle, length = 100.0, 9.0, 3.4, 6.5, 2.8, 40.0
    corridors, rooms = [Rect(0.0, base, width, base + spine)], []
    rooms += _row(rng, Rect(0.0, 0.0, width, base), "north", 6.0, 1.3, "A")
    foot, wing = base + spine, 2 * wing_depth + aisle
    outline = [(0.0, 0.0), (width, 0.0), (width, foot)]
    for number, west in enumerate((width - wing - 4.0, (width - wing) / 2, 4.0)):
        top, east, label = foot + length - 4.0 * number, west + wing, "DCB"[number]
        corridors.append(Rect(west + wing_depth, foot, east - wing_depth, top))
        rooms += _row(rng, Rect(west, foot, west + wing_depth, top), "east", 5.0, 1.3, f"{label}w")
        rooms += _row(rng, Rect(east - wing_depth, foot, east, top), "west", 5.0, 1.3, f"{label}e")
        outline += [(east, foot), (east, top), (west, top), (west, foot)]
    outline.append((0.0, foot))
    return Layout(tuple(outline), tuple(corridors), tuple(rooms), (2.5, 4.0, 4.0, 6.0, 10.0), 13.0)


LAYOUTS: dict[str, Callable[[np.random.Generator], Layout]] = {"office": office, "mall": mall, "hospital": hospital}
"""Kind of building -> a floor of it."""
