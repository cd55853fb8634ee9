"""Moving partition: candidates are the reference points within a radius of the last fix.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, section 4.1 (docs/methods/two_stage_ekf.md).
Equation 4 counts how many points of a regular grid enter and leave an array. Differs from the paper: points here lie
anywhere, so the partition is made anew about each fix from the squares that its circle touches. Whoever looks for the
points that enter looks at those squares too; knowing the old members would save nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numba
import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.radio_map import RadioMap

_SIDE_M = 2.5


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """points : (m,) ascending reference points of a floor within radius_m of a place."""

    floor: int
    radius_m: float
    points: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class PointGrid:
    """Reference points by square of _SIDE_M.

    key : (p,) ascending number of the square, floor by floor, column by column.  point : (p,) in that order.
    west_m, south_m : corner of all floors' squares.  columns, rows : of one floor.
    """

    key: IntArray
    point: IntArray
    xy_m: FloatArray
    west_m: float
    south_m: float
    columns: int
    rows: int


_held: WeakKeyDictionary[RadioMap, PointGrid] = WeakKeyDictionary()


def partition_around(radio_map: RadioMap, floor: int, x_m: float, y_m: float, radius_m: float) -> Partition:
    """The partition about a place; looks at the squares that the circle touches only."""
    grid = _grid_of(radio_map)
    points = _within(
        grid.key, grid.point, grid.xy_m, grid.west_m, grid.south_m, grid.columns, grid.rows, floor, x_m, y_m, radius_m
    )
    return Partition(floor, radius_m, points)


def _grid_of(radio_map: RadioMap) -> PointGrid:
    grid = _held.get(radio_map)
    if grid is None:
        grid = _held[radio_map] = _build(radio_map)
    return grid


def _build(radio_map: RadioMap) -> PointGrid:
    xy_m = radio_map.xy_m
    if len(xy_m) == 0:
        return PointGrid(np.empty(0, np.int64), np.empty(0, np.int64), xy_m, 0.0, 0.0, 1, 1)
    west_m, south_m = xy_m.min(axis=0).tolist()
    square = np.floor((xy_m - (west_m, south_m)) / _SIDE_M).astype(np.int64)
    columns, rows = (square.max(axis=0) + 1).tolist()
    key = (radio_map.floor.astype(np.int64) * columns + square[:, 0]) * rows + square[:, 1]
    point = np.argsort(key, kind="stable")
    return PointGrid(key[point], point, xy_m, west_m, south_m, columns, rows)


@numba.njit(cache=True, nogil=True)
def _within(
    key: IntArray,
    point: IntArray,
    xy_m: FloatArray,
    west_m: float,
    south_m: float,
    columns: int,
    rows: int,
    floor: int,
    x_m: float,
    y_m: float,
    radius_m: float,
) -> IntArray:
    found = np.empty(len(point), np.int64)
    count = 0
    first_column = max(int(np.floor((x_m - radius_m - west_m) / _SIDE_M)), 0)
    last_column = min(int(np.floor((x_m + radius_m - west_m) / _SIDE_M)), columns - 1)
    first_row = max(int(np.floor((y_m - radius_m - south_m) / _SIDE_M)), 0)
    last_row = min(int(np.floor((y_m + radius_m - south_m) / _SIDE_M)), rows - 1)
    if first_row > last_row:
        return found[:0].copy()
    for column in range(first_column, last_column + 1):
        base = (floor * columns + column) * rows
        begin = np.searchsorted(key, base + first_row)
        while begin < len(key) and key[begin] <= base + last_row:
            p = point[begin]
            if np.hypot(xy_m[p, 0] - x_m, xy_m[p, 1] - y_m) <= radius_m:
                found[count] = p
                count += 1
            begin += 1
    return np.sort(found[:count])
