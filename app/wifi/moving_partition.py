"""Moving partition: candidates are the reference points within a radius of the last fix, kept while it moves.

two_stage_ekf_moving_partition.txt, section 4.1 (methods.md B). Equation 4 counts how many points of a regular grid
enter and leave an array. Differs from the paper: points here lie anywhere, so instead of counting, members that are out
of reach leave and the points of the squares about the new circle that the old one did not hold enter.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numba
import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.radio_map import Int32Array, RadioMap

RADIUS_M = 2.5
"""The paper's: how far one walks in a second."""
_SIDE_M = 2.5


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """points : (m,) ascending reference points of a floor within radius_m of a place."""

    floor: int
    x_m: float
    y_m: float
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
    floor: Int32Array
    xy_m: FloatArray
    west_m: float
    south_m: float
    columns: int
    rows: int


_held: WeakKeyDictionary[RadioMap, PointGrid] = WeakKeyDictionary()


def partition_around(radio_map: RadioMap, floor: int, x_m: float, y_m: float, radius_m: float = RADIUS_M) -> Partition:
    """A partition from nothing: at the start, or when the last one lost its walker."""
    return Partition(floor, x_m, y_m, radius_m, points_within(radio_map, floor, x_m, y_m, radius_m))


def moved_partition(radio_map: RadioMap, partition: Partition, x_m: float, y_m: float) -> Partition:
    """The partition about the next place on the same floor; equal to partition_around there."""
    grid, r = _grid_of(radio_map), partition.radius_m
    near = _within(grid, partition.floor, x_m, y_m, r)
    points = _exchange(grid.xy_m, partition.points, near, partition.x_m, partition.y_m, x_m, y_m, r)
    return Partition(partition.floor, x_m, y_m, r, points)


def points_within(radio_map: RadioMap, floor: int, x_m: float, y_m: float, radius_m: float) -> IntArray:
    """(m,) ascending reference points of a floor within a radius; looks at the squares it touches only."""
    return _within(_grid_of(radio_map), floor, x_m, y_m, radius_m)


def _grid_of(radio_map: RadioMap) -> PointGrid:
    grid = _held.get(radio_map)
    if grid is None:
        grid = _held[radio_map] = _build(radio_map)
    return grid


def _build(radio_map: RadioMap) -> PointGrid:
    xy_m = radio_map.xy_m
    if len(xy_m) == 0:
        return PointGrid(np.empty(0, np.int64), np.empty(0, np.int64), radio_map.floor, xy_m, 0.0, 0.0, 1, 1)
    west_m, south_m = xy_m.min(axis=0).tolist()
    square = np.floor((xy_m - (west_m, south_m)) / _SIDE_M).astype(np.int64)
    columns, rows = (square.max(axis=0) + 1).tolist()
    key = (radio_map.floor.astype(np.int64) * columns + square[:, 0]) * rows + square[:, 1]
    point = np.argsort(key, kind="stable")
    return PointGrid(key[point], point, radio_map.floor, xy_m, west_m, south_m, columns, rows)


def _within(grid: PointGrid, floor: int, x_m: float, y_m: float, radius_m: float) -> IntArray:
    return _search(
        grid.key, grid.point, grid.xy_m, grid.west_m, grid.south_m, grid.columns, grid.rows, floor, x_m, y_m, radius_m
    )


@numba.njit(cache=True, nogil=True)
def _search(
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


@numba.njit(cache=True, nogil=True)
def _exchange(
    xy_m: FloatArray,
    members: IntArray,
    near: IntArray,
    from_x_m: float,
    from_y_m: float,
    x_m: float,
    y_m: float,
    radius_m: float,
) -> IntArray:
    points = np.empty(len(members) + len(near), np.int64)
    count = 0
    for p in members:
        if np.hypot(xy_m[p, 0] - x_m, xy_m[p, 1] - y_m) <= radius_m:
            points[count] = p
            count += 1
    for p in near:
        if np.hypot(xy_m[p, 0] - from_x_m, xy_m[p, 1] - from_y_m) > radius_m:
            points[count] = p
            count += 1
    return np.sort(points[:count])
