"""How far a radio map can be trusted, by its survey alone: error cells, gaps, unsteady access points, look-alikes.

Everything is on arrays; who matches scans hands the outcome in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from app.estimation.arrays import BoolArray, FloatArray, IntArray

SMALLEST_GAP_M2 = 10.0
"""Smaller corners are of no use to name."""
LEAST_REPEATS = 10
"""Repetitions from which an access point's steadiness is judged: a standard deviation of ten is known to 25 %."""
UNSTEADY = 2.0
"""Times the median spread from which an access point counts as unsteady."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorCells:
    """Errors gathered in c squares.

    xy_m : (c, 2) centres.  mean_m, worst_m : (c,).  level_m : (c,) mean protection level.  scans, walks : (c,) how
    many.
    """

    xy_m: FloatArray
    mean_m: FloatArray
    worst_m: FloatArray
    level_m: FloatArray
    scans: IntArray
    walks: IntArray


@dataclass(frozen=True, slots=True)
class Gap:
    """Connected area without survey. bounds_m : west, south, east, north.  xy_m : the place in it farthest from any
    survey, at distance_m."""

    area_m2: float
    bounds_m: tuple[float, float, float, float]
    xy_m: tuple[float, float]
    distance_m: float


def error_cells(
    xy_m: FloatArray, error_m: FloatArray, level_m: FloatArray, walk: IntArray, cell_m: float
) -> ErrorCells:
    """Gather errors by place.

    Parameters
    ----------
    xy_m : (n, 2) true places.  error_m : (n,).  level_m : (n,) protection level that was given with it.
    walk : (n,) number of the walk that each is of.
    """
    column_row, cell = np.unique(np.floor(xy_m / cell_m).astype(np.int64), axis=0, return_inverse=True)
    cell, count = cell.reshape(-1), len(column_row)
    scans = np.bincount(cell, minlength=count)
    worst_m = np.zeros(count)
    np.maximum.at(worst_m, cell, error_m)
    pairs = np.unique(np.column_stack([cell, walk]), axis=0)
    return ErrorCells(
        xy_m=(column_row.astype(np.float64) + 0.5) * cell_m,
        mean_m=np.bincount(cell, error_m, minlength=count) / scans,
        worst_m=worst_m,
        level_m=np.bincount(cell, level_m, minlength=count) / scans,
        scans=scans,
        walks=np.bincount(pairs[:, 0], minlength=count),
    )


def coverage_gaps(
    walkable: BoolArray, cell_m: float, survey_xy_m: FloatArray, reach_m: float
) -> tuple[float, BoolArray, list[Gap]]:
    """Where no survey scan is near.

    Parameters
    ----------
    walkable : (rows, columns) cells that count, rows from south to north.  survey_xy_m : (n, 2).
    reach_m : a scan covers what is within.

    Returns
    -------
    Share of the walkable area that is covered (1 of none), the cells that are not, and connected areas of them, the
    largest first.
    """
    distance_m = np.full(walkable.shape, np.inf)
    row, column = np.nonzero(walkable)
    if len(row) and len(survey_xy_m):
        centre_m = (np.column_stack([column, row]) + 0.5) * cell_m
        distance_m[row, column] = cKDTree(survey_xy_m).query(centre_m)[0]
    missing = walkable & (distance_m > reach_m)
    share = 1.0 - float(missing.sum()) / len(row) if len(row) else 1.0
    label, _ = ndimage.label(missing, np.ones((3, 3)))
    gaps = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(label), start=1):
        here = label[rows, columns] == number
        area_m2 = float(here.sum()) * cell_m**2
        if area_m2 < SMALLEST_GAP_M2:
            continue
        far_m = np.where(here, distance_m[rows, columns], -1.0)
        at_row, at_column = np.unravel_index(int(far_m.argmax()), far_m.shape)
        gaps.append(
            Gap(
                area_m2=area_m2,
                bounds_m=(
                    columns.start * cell_m,
                    rows.start * cell_m,
                    columns.stop * cell_m,
                    rows.stop * cell_m,
                ),
                xy_m=(
                    float((columns.start + at_column + 0.5) * cell_m),
                    float((rows.start + at_row + 0.5) * cell_m),
                ),
                distance_m=float(far_m[at_row, at_column]),
            )
        )
    return share, missing, sorted(gaps, key=lambda gap: -gap.area_m2)


def between_walk_spread(
    access_point: IntArray, cell: IntArray, walk: IntArray, rssi_dbm: FloatArray
) -> tuple[FloatArray, IntArray]:
    """How much an access point differs from walk to walk at the same place.

    Each walk's own offset (its phone, its bearer) is taken out first.

    Parameters
    ----------
    access_point, cell, walk, rssi_dbm : (n,) readings; numbers from 0.

    Returns
    -------
    (a,) standard deviation in dB over walks, pooled over places; NaN with fewer than LEAST_REPEATS repetitions.
    (a,) repetitions: walks beyond the first of each place.
    """
    place, of_place, walks, mean_dbm = _walk_means(access_point, cell, walk, rssi_dbm)
    repeated = np.bincount(of_place) >= 2
    known = repeated[of_place]
    for _ in range(3):  # offsets and places depend on one another
        residual_db = mean_dbm - _means(of_place, mean_dbm)[of_place]
        mean_dbm = mean_dbm - _walk_offsets(walks[known], residual_db[known], int(walk.max(initial=-1)) + 1)[walks]
    residual_db = mean_dbm - _means(of_place, mean_dbm)[of_place]
    count = int(access_point.max(initial=-1)) + 1
    square_db2 = np.bincount(place, np.bincount(of_place, residual_db**2), minlength=count)
    repeats = np.bincount(place, np.bincount(of_place) - 1, minlength=count).astype(np.int64)
    spread_db = np.sqrt(square_db2 / np.maximum(repeats, 1))
    return np.where(repeats >= LEAST_REPEATS, spread_db, np.nan), repeats


def look_alikes(
    xy_m: FloatArray, floor: IntArray, signal_distance: FloatArray, near_m: float, far_m: float
) -> tuple[float, IntArray]:
    """Places far apart that sound as alike as neighbours do.

    Parameters
    ----------
    xy_m : (p, 2).  floor : (p,).  signal_distance : (p, p), symmetric.
    near_m : neighbours are closer.  far_m : look-alikes are farther, or on different floors.

    Returns
    -------
    The median signal distance of neighbours (0 without any), and (k, 2) pairs with no more, most alike first.
    """
    first, second = np.triu_indices(len(xy_m), 1)
    distance = signal_distance[first, second]
    apart_m = np.hypot(*(xy_m[first] - xy_m[second]).T)
    same = floor[first] == floor[second]
    neighbours = distance[same & (apart_m < near_m)]
    limit = float(np.median(neighbours)) if len(neighbours) else 0.0
    alike = np.flatnonzero((distance <= limit) & (~same | (apart_m >= far_m)))
    alike = alike[np.argsort(distance[alike], kind="stable")]
    return limit, np.column_stack([first[alike], second[alike]])


def distinct_pairs(pairs: IntArray, xy_m: FloatArray, floor: IntArray, within_m: float, most: int) -> IntArray:
    """The first pairs of places of which no earlier one tells the same: both ends within a distance of its ends."""
    kept: list[tuple[int, int]] = []
    for one, other in pairs.tolist():
        ends = np.array([[one, other], [other, one]])
        for had in kept:
            near = np.hypot(*(xy_m[ends] - xy_m[list(had)]).transpose(2, 0, 1)) < within_m
            if (near & (floor[ends] == floor[list(had)])).all(axis=1).any():
                break
        else:
            kept.append((one, other))
            if len(kept) == most:
                break
    return np.array(kept, np.int64).reshape(-1, 2)


def smallest_risk(walks: int) -> float:
    """The smallest risk that so many calibration walks can support: a conformal quantile needs 1 / risk - 1."""
    return 1.0 / (walks + 1)


def conformal_level(score_m: FloatArray, risk: float) -> float | None:
    """What a further walk stays within with probability 1 - risk, if it is like those before.

    Parameters
    ----------
    score_m : (n,) one number a walk, so that its correlated scans count once.

    Returns
    -------
    The ceil((n + 1) (1 - risk))-th smallest score; None where there are too few walks for this risk.
    """
    rank = math.ceil((len(score_m) + 1) * (1.0 - risk) - 1e-9)
    return float(np.sort(score_m)[rank - 1]) if 1 <= rank <= len(score_m) else None


def _walk_means(
    access_point: IntArray, cell: IntArray, walk: IntArray, rssi_dbm: FloatArray
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Mean reading of each walk at each place: access point of every place, and place, walk and mean of every visit."""
    visit, of_visit = np.unique(np.column_stack([access_point, cell, walk]), axis=0, return_inverse=True)
    place, of_place = np.unique(visit[:, :2], axis=0, return_inverse=True)
    return place[:, 0], of_place.reshape(-1), visit[:, 2], _means(of_visit.reshape(-1), rssi_dbm)


def _means(group: IntArray, value: FloatArray) -> FloatArray:
    return np.asarray(np.bincount(group, value) / np.bincount(group), np.float64)


def _walk_offsets(walk: IntArray, residual_db: FloatArray, count: int) -> FloatArray:
    """(count,) median residual of each walk, 0 of a walk without any."""
    offset_db = np.zeros(count)
    order = np.argsort(walk, kind="stable")
    number, start = np.unique(walk[order], return_index=True)
    for one, residuals in zip(number.tolist(), np.split(residual_db[order], start[1:]), strict=False):
        offset_db[one] = np.median(residuals)
    return offset_db
