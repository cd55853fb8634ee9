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
from app.floorplan.walkable import plan_polygons, walkable_cells

CELL_M = 0.5
MOST_CELLS = 4_000_000
"""Of a floor; a larger one gets larger cells."""
AROUND_M = 1.0
"""So near to where somebody has been one can be as well, whatever the plan says."""
VISITS, DEPTH_M = 3, 1.0
"""A room is open to walkers if so many surveyed places lie so deep inside of it. Plans are drawn, and surveyors placed,
to a metre: of places surveyed in the mall's corridors 1 in 50 lies in a shop by that."""
LEAST_AGREEMENT = 0.9
"""Share of the surveyed places that a plan must leave free. One that fewer fit is drawn at another place."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeSpace:
    """cells : (rows, columns) whether one can be there, rows from south to north from the frame's origin; outside of
    them nobody is.  cell_m : side of a cell."""

    cells: BoolArray
    cell_m: float


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
    NO_PLAN where there is none, it draws nothing, or it contradicts the survey.
    """
    if plan is None or georeference is None or not len(visited_xy_m):
        return NO_PLAN
    features = plan_polygons(plan, georeference)
    if not features:
        return NO_PLAN
    cell_m = max(CELL_M, math.sqrt(size_m[0] * size_m[1] / MOST_CELLS))
    cells = walkable_cells(features, visited_xy_m, size_m, cell_m, VISITS, DEPTH_M)
    column, row = np.floor(visited_xy_m / cell_m).astype(np.int64).T
    within = (row >= 0) & (row < cells.shape[0]) & (column >= 0) & (column < cells.shape[1])
    if np.count_nonzero(cells[row[within], column[within]]) < LEAST_AGREEMENT * len(visited_xy_m):
        return NO_PLAN
    visited = np.zeros_like(cells)
    visited[row[within], column[within]] = True
    reach = math.ceil(AROUND_M / cell_m)
    disc = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) * cell_m <= AROUND_M
    return FreeSpace(np.ascontiguousarray(cells | binary_dilation(visited, disc)), cell_m)
