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


def plan_polygons(plan: Mapping[str, Any], georeference: Georeference) -> list[list[Polygon]]:
    """The polygons of every feature of an accepted plan that has any, in order; the first is the outline."""
    features = ([*_polygons(feature.get("geometry"), georeference)] for feature in plan["features"])
    return [polygons for polygons in features if polygons]


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
    walkable = _inside(features[0], shape, cell_m)
    for room in features[1:]:
        covered = _inside(room, shape, cell_m)
        inner = covered
        if depth_m >= cell_m and np.count_nonzero(covered[row[within], column[within]]) >= visits:
            inner = binary_erosion(covered, iterations=round(depth_m / cell_m))
        if np.count_nonzero(inner[row[within], column[within]]) < visits:
            walkable &= ~covered
    return walkable


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


def _inside(polygons: list[Polygon], shape: tuple[int, int], cell_m: float) -> BoolArray:
    """Cells whose centre lies in one of the polygons, by the even-odd rule, row by row."""
    inside = np.zeros(shape, np.bool_)
    for polygon in polygons:
        turns = np.zeros((shape[0], shape[1] + 1), np.int64)
        for ring in polygon:
            for (x0, y0), (x1, y1) in zip(ring[:-1].tolist(), ring[1:].tolist(), strict=True):
                if y0 == y1:
                    continue
                south, north = min(y0, y1), max(y0, y1)
                first, after = (math.ceil(y / cell_m - 0.5) for y in (south, north))  # centres in [south, north)
                rows = np.arange(max(first, 0), min(after, shape[0]))
                crossing_m = x0 + ((rows + 0.5) * cell_m - y0) * (x1 - x0) / (y1 - y0)
                columns = np.clip(np.ceil(crossing_m / cell_m - 0.5), 0, shape[1]).astype(np.int64)
                turns[rows, columns] += 1
        inside |= np.cumsum(turns, axis=1)[:, :-1] % 2 == 1
    return inside
