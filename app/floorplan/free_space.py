"""Where a floor's walkers can be, as a grid that a filter can ask a thousand times a step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation

from app.estimation.arrays import BoolArray, FloatArray
from app.floorplan.georeference import Georeference
from app.floorplan.walkable import drawing_work, least_work, plan_polygons, walkable_cells

CELL_M = 0.5
MOST_CELLS = 4_000_000
"""Of a floor; a larger one gets larger cells."""
MOST_WORK = 150_000_000
"""To draw a plan, as drawing_work counts it: one or two seconds. A mall's takes a hundredth; a plan that takes more has
no walls, since every phone of the venue would wait for them.
"""
AROUND_M = 1.0
"""So near to where somebody has been one can be as well, whatever the plan says."""
VISITS, DEPTH_M = 3, 1.0
"""A room is open to walkers if so many surveyed places lie so deep inside of it. Plans are drawn, and surveyors placed,
to a metre: of places surveyed in the mall's corridors 1 in 50 lies in a shop by that."""
MOST_ENTERED = 0.03
"""Share of the surveyed places that may lie so deep in rooms before it is plain that people go into rooms here: those
that nobody surveyed are then no walls either. The mall's surveyors kept to the corridors."""
LEAST_AGREEMENT = 0.9
"""Share of the surveyed places that a plan must leave free. One that fewer fit is drawn at another place."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeSpace:
    """cells : (rows, columns) whether one can be there, rows from south to north from the frame's origin; outside of
    them nobody is.  cell_m : side of a cell."""

    cells: BoolArray
    cell_m: float

    @property
    def walled(self) -> bool:
        """Whether a plan says where one cannot be."""
        return self.cells.size > 0

    def is_free(self, xy_m: FloatArray) -> BoolArray:
        """(n,) of places (n, 2) of a walled floor."""
        column, row = np.floor(xy_m / self.cell_m).astype(np.int64).T
        within = (row >= 0) & (row < self.cells.shape[0]) & (column >= 0) & (column < self.cells.shape[1])
        return np.asarray(within & self.cells[row * within, column * within], np.bool_)


NO_PLAN = FreeSpace(np.ones((0, 0), np.bool_), 1.0)
"""Everything is free."""


def free_space(
    plan: Mapping[str, Any] | None,
    georeference: Georeference | None,
    size_m: tuple[float, float],
    visited_xy_m: FloatArray,
) -> FreeSpace:
    """The free space of a floor.

    Parameters
    ----------
    plan : as accepted by the service, GeoJSON.  size_m : east and north.
    visited_xy_m : (n, 2) where surveyors were: a room that one of them was in is no obstacle.

    Returns
    -------
    NO_PLAN where there is none, it draws nothing, takes too long to draw, or contradicts the survey.
    """
    if plan is None or georeference is None or not len(visited_xy_m) or least_work(plan) > MOST_WORK:
        return NO_PLAN
    features = plan_polygons(plan, georeference)
    if not features:
        return NO_PLAN
    cell_m = max(CELL_M, math.sqrt(size_m[0] * size_m[1] / MOST_CELLS))
    if drawing_work(features, size_m, cell_m) > MOST_WORK:
        return NO_PLAN
    cells = walkable_cells(features, visited_xy_m, size_m, cell_m, VISITS, DEPTH_M)
    outline = walkable_cells(features[:1], visited_xy_m, size_m, cell_m)
    corridors = walkable_cells(features, np.empty((0, 2)), size_m, cell_m)
    column, row = np.floor(visited_xy_m / cell_m).astype(np.int64).T
    within = (row >= 0) & (row < cells.shape[0]) & (column >= 0) & (column < cells.shape[1])
    row, column = row[within], column[within]
    in_rooms = outline & ~_around(corridors, DEPTH_M, cell_m)
    if np.count_nonzero(in_rooms[row, column]) > MOST_ENTERED * len(visited_xy_m):
        cells = outline
    if np.count_nonzero(cells[row, column]) < LEAST_AGREEMENT * len(visited_xy_m):
        return NO_PLAN
    visited = np.zeros_like(cells)
    visited[row, column] = True
    return FreeSpace(np.ascontiguousarray(cells | _around(visited, AROUND_M, cell_m)), cell_m)


def _around(cells: BoolArray, reach_m: float, cell_m: float) -> BoolArray:
    """The cells, and those within reach of one."""
    reach = math.ceil(reach_m / cell_m)
    disc = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) * cell_m <= reach_m
    return np.asarray(binary_dilation(cells, disc), np.bool_)
