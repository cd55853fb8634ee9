"""Walls from a layout, and what they cost a radio signal."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit

from app.estimation.arrays import BoolArray, FloatArray
from app.simulation.layouts import Layout, Rect

OUTER_WALL_LOSS_DB = 9.0
LARGEST_LOSS_DB = 32.0
"""Walls add up to no more than this: what is lost straight through arrives around corners."""


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """Segments (m, 2) to (m, 2) and what crossing each costs, (m,) dB."""

    start_m: FloatArray
    end_m: FloatArray
    loss_db: FloatArray

    def loss_between_db(self, from_m: FloatArray, to_m: FloatArray) -> FloatArray:
        """Loss (n,) along the straight lines from (n, 2) to (n, 2): crossed walls, saturating at LARGEST_LOSS_DB."""
        crossed = _crossed_db(from_m, to_m, self.start_m, self.end_m, self.loss_db)
        return np.asarray(LARGEST_LOSS_DB * -np.expm1(-crossed / LARGEST_LOSS_DB), dtype=np.float64)


@njit(cache=True)
def _crossed_db(
    from_m: FloatArray, to_m: FloatArray, start_m: FloatArray, end_m: FloatArray, loss_db: FloatArray
) -> FloatArray:
    """Sum (n,) of the losses of the walls (m, 2) to (m, 2) that each line (n, 2) to (n, 2) crosses."""
    total = np.zeros(len(from_m))
    for i in range(len(from_m)):
        x, y = from_m[i]
        dx, dy = to_m[i, 0] - x, to_m[i, 1] - y
        for j in range(len(loss_db)):
            ax, ay = start_m[j, 0] - x, start_m[j, 1] - y
            bx, by = end_m[j, 0] - x, end_m[j, 1] - y
            if (dx * ay - dy * ax) * (dx * by - dy * bx) >= 0.0:
                continue  # both ends of the wall on one side of the line
            wx, wy = bx - ax, by - ay
            if (wy * ax - wx * ay) * (wy * (ax - dx) - wx * (ay - dy)) < 0.0:
                total[i] += loss_db[j]
    return total


def walls_of(layout: Layout, rng: np.random.Generator) -> Walls:
    """Walls along the edges of rooms and corridors, open at doors and where corridors meet.

    Loss is drawn wall by wall from the layout's materials; walls on the outline are outer walls.
    """
    areas = [*layout.corridors, *(room.area for room in layout.rooms)]
    doors = [room.door for room in layout.rooms]
    pieces: list[tuple[float, float, float, float]] = []
    for flipped in (False, True):  # walls along x, then, with x and y exchanged, along y
        rects, corridors, gaps = (_flipped(group, flipped) for group in (areas, layout.corridors, doors))
        for y in sorted({edge for r in rects for edge in (r.y0, r.y1)}):
            for x0, x1 in _along(y, rects, corridors, gaps):
                pieces.append((y, x0, y, x1) if flipped else (x0, y, x1, y))
    ends = np.array(pieces, dtype=np.float64).reshape(-1, 4)
    loss = rng.choice(np.array(layout.wall_losses_db), len(ends))
    middle = (ends[:, :2] + ends[:, 2:]) / 2
    loss[_on_outline(middle, layout.outline)] = OUTER_WALL_LOSS_DB
    return Walls(ends[:, :2].copy(), ends[:, 2:].copy(), loss)


def _flipped(rects: Iterable[Rect], flipped: bool) -> list[Rect]:
    return [Rect(r.y0, r.x0, r.y1, r.x1) if flipped else r for r in rects]


def _along(y: float, rects: list[Rect], corridors: list[Rect], gaps: list[Rect]) -> list[tuple[float, float]]:
    """Walls on the line of that y: its edges less its openings, cut wherever an edge or opening ends."""
    edges = [(r.x0, r.x1) for r in rects if y in (r.y0, r.y1)]
    openings = [(g.x0, g.x1) for g in gaps if g.y0 == g.y1 == y]
    openings += [(c.x0, c.x1) for c in corridors if c.y0 < y < c.y1]
    for below in (c for c in corridors if c.y1 == y):
        for above in (c for c in corridors if c.y0 == y):
            if max(below.x0, above.x0) < min(below.x1, above.x1):
                openings.append((max(below.x0, above.x0), min(below.x1, above.x1)))
    cuts = sorted({x for span in edges + openings for x in span})
    walls = []
    for x0, x1 in pairwise(cuts):
        middle = (x0 + x1) / 2
        inside = any(a < middle < b for a, b in edges) and not any(a < middle < b for a, b in openings)
        if inside and x1 - x0 > 0.01:
            walls.append((x0, x1))
    return walls


def _on_outline(points: FloatArray, outline: tuple[tuple[float, float], ...]) -> BoolArray:
    found = np.zeros(len(points), dtype=np.bool_)
    for (x0, y0), (x1, y1) in zip(outline, (*outline[1:], outline[0]), strict=True):
        in_x = (points[:, 0] >= min(x0, x1) - 0.01) & (points[:, 0] <= max(x0, x1) + 0.01)
        in_y = (points[:, 1] >= min(y0, y1) - 0.01) & (points[:, 1] <= max(y0, y1) + 0.01)
        found |= in_x & in_y
    return found
