"""Where on a floor people can walk, as far as its plan tells: inside the outline, outside of rooms nobody goes into."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.ndimage import binary_erosion

from app.estimation.arrays import BoolArray, FloatArray
from app.floorplan.georeference import Georeference

Polygon = list[FloatArray]
"""Rings of (n, 2) metres in the floor's frame; what lies in an odd number of them is inside."""
CROSSING_WORK, FEATURE_WORK = 20, 10_000
"""What an edge's crossing of one row, and a feature of any size, take of the time that a cell takes."""


def plan_polygons(plan: Mapping[str, Any], georeference: Georeference) -> list[list[Polygon]]:
    """The polygons of every feature of an accepted plan that has any, in order; the first is the outline."""
    features = ([*_polygons(feature.get("geometry"), georeference)] for feature in plan["features"])
    return [polygons for polygons in features if polygons]


def least_work(plan: Mapping[str, Any]) -> float:
    """What drawing_work cannot be less than, told without a look at the corners of an accepted plan."""
    kinds = [(feature.get("geometry") or {}).get("type") for feature in plan["features"]]
    return float(FEATURE_WORK * (kinds.count("Polygon") + kinds.count("MultiPolygon")))


def walkable_cells(
    features: list[list[Polygon]],
    visited_xy_m: FloatArray,
    size_m: tuple[float, float],
    cell_m: float,
    visits: int = 1,
    depth_m: float = 0.0,
) -> BoolArray:
    """Which cells of a grid over the floor can be walked on, judged at their centres.

    Parameters
    ----------
    features : as plan_polygons gives them; none: everything within the frame.
    visited_xy_m : (n, 2) places that somebody has been to; a room with so many visits of them, so deep inside of it, is
    no obstacle.
    size_m : east and north.  cell_m : side of a cell.

    Returns
    -------
    (rows, columns), rows from south to north.
    """
    shape = math.ceil(size_m[1] / cell_m), math.ceil(size_m[0] / cell_m)
    if not features:
        return np.ones(shape, np.bool_)
    column, row = np.floor(visited_xy_m / cell_m).astype(np.int64).T
    within = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    visited = np.zeros(shape, np.int32)
    np.add.at(visited, (row[within], column[within]), 1)
    walkable = np.zeros(shape, np.bool_)
    window, covered = _inside(features[0], shape, cell_m)
    walkable[window] = covered
    for room in features[1:]:
        window, covered = _inside(room, shape, cell_m)
        inner, been = covered, visited[window]
        if depth_m >= cell_m and been[covered].sum() >= visits:
            inner = binary_erosion(covered, iterations=round(depth_m / cell_m))
        if been[inner].sum() < visits:
            walkable[window] &= ~covered
    return walkable


def drawing_work(features: list[list[Polygon]], size_m: tuple[float, float], cell_m: float) -> float:
    """What walkable_cells has to do for a plan of at least one feature, counted in cells that it looks at."""
    rings = [[ring for polygon in polygons for ring in polygon] for polygons in features]
    corners = np.clip(np.concatenate([ring for of_one in rings for ring in of_one]), 0.0, size_m) / cell_m
    ring_ends = np.cumsum([len(ring) for of_one in rings for ring in of_one])
    feature_ends = np.cumsum([len(of_one) for of_one in rings])
    rows = np.abs(np.diff(corners[:, 1]))
    rows[ring_ends[:-1] - 1] = 0.0  # from one ring to the next there is no edge
    low, high, cells = corners, corners, 0.0
    for ends in (ring_ends, feature_ends):
        starts = np.concatenate([[0], ends[:-1]])
        low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
        cells += float((high - low + 1.0).prod(axis=1).sum())
    return cells + CROSSING_WORK * (float(rows.sum()) + len(corners)) + FEATURE_WORK * len(features)


def _polygons(geometry: Mapping[str, Any] | None, georeference: Georeference) -> Iterator[Polygon]:
    match geometry:
        case {"type": "Polygon", "coordinates": rings}:
            yield [_local(ring, georeference) for ring in rings]
        case {"type": "MultiPolygon", "coordinates": polygons}:
            for rings in polygons:
                yield [_local(ring, georeference) for ring in rings]
        case {"type": "GeometryCollection", "geometries": geometries}:
            for one in geometries:
                yield from _polygons(one, georeference)


def _local(ring: list[list[float]], georeference: Georeference) -> FloatArray:
    return np.array([georeference.to_local(position[1], position[0]) for position in ring], np.float64).reshape(-1, 2)


def _inside(polygons: list[Polygon], shape: tuple[int, int], cell_m: float) -> tuple[tuple[slice, slice], BoolArray]:
    """The part of the grid around the polygons, and which of its cells have their centre in one of them."""
    rows, columns = window = _window([ring for polygon in polygons for ring in polygon], shape, cell_m)
    if len(polygons) == 1:
        return window, _filled(polygons[0], rows, columns, cell_m)
    inside = np.zeros((rows.stop - rows.start, columns.stop - columns.start), np.bool_)
    for polygon in polygons:
        south, west = _window(polygon, shape, cell_m)
        part = inside[
            south.start - rows.start : south.stop - rows.start, west.start - columns.start : west.stop - columns.start
        ]
        part |= _filled(polygon, south, west, cell_m)
    return window, inside


def _window(rings: list[FloatArray], shape: tuple[int, int], cell_m: float) -> tuple[slice, slice]:
    """Rows and columns of the grid within which the rings' insides lie; empty beside the grid."""
    corners = np.concatenate(rings) / cell_m
    first = np.clip(np.floor(corners.min(axis=0)), 0, shape[::-1]).astype(np.int64).tolist()
    after = np.clip(np.ceil(corners.max(axis=0)), 0, shape[::-1]).astype(np.int64).tolist()
    return slice(first[1], after[1]), slice(first[0], after[0])


def _filled(polygon: Polygon, rows: slice, columns: slice, cell_m: float) -> BoolArray:
    """Cells of a window whose centre lies inside, by the even-odd rule, row by row."""
    width = columns.stop - columns.start
    turns = np.zeros((rows.stop - rows.start, width + 1), np.uint8)
    for ring in polygon:
        start, end = ring[:-1], ring[1:]
        start, end = start[start[:, 1] != end[:, 1]], end[start[:, 1] != end[:, 1]]
        south_m, north_m = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
        first, after = (  # centres in [south, north)
            np.clip(np.ceil(y_m / cell_m - 0.5), rows.start, rows.stop).astype(np.int64) for y_m in (south_m, north_m)
        )
        count = after - first
        edge = np.repeat(np.arange(len(count)), count)
        row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + first[edge]
        east_m, rise_m = (end - start)[edge].T
        crossing_m = start[edge, 0] + ((row + 0.5) * cell_m - start[edge, 1]) * east_m / rise_m
        column = np.clip(np.ceil(crossing_m / cell_m - 0.5) - columns.start, 0, width).astype(np.int64)
        np.add.at(turns, (row - rows.start, column), np.uint8(1))  # wraps round, and stays odd or even
    filled: BoolArray = np.cumsum(turns, axis=1, dtype=np.uint8)[:, :-1] % 2 == 1
    return filled
