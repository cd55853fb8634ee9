"""How unlike its map a survey itself sounds when whole walks are left out: what use is later compared with.

By squares of CELL_M, because scans of some places are less like their surroundings than those of others, and by visits
(one walk in one square), because the scans of a walk are correlated. Everything is of the logarithm of the signal
distance, which is nearly normal over places and visits (mall: kurtosis 3.5 to 6.5; of the distance itself 12).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.fingerprint import Fingerprint
from app.wifi.left_out import LeftOutScans

CELLS, FLOORS = "likeness_cells", "likeness_floors"
"""Sections of the radio map: the fields below side by side, a row for each square, and for each floor."""
CELL_M = 10.0
REACH_M = 5.0
"""Only scans count that others of the survey were near to: where a walk was alone, leaving it out leaves a gap, and a
gap is unlike everything."""
LEAST_DISTANCE = 1e-4
"""Logarithms are taken of no less."""
LEAST_REPEATS = 20
"""Of visits, and of squares, from which a floor's own spread is taken."""
LEAST_WITHIN = 1e-3
"""Variance of a visit about its square; of a walk that was sent in twice there is none."""
USUAL_MEAN, USUAL_BETWEEN, USUAL_WITHIN = -2.3, 0.30, 0.12
"""Of a survey too small to tell: as both mall floors (mean, variance between and within squares)."""


@dataclass(frozen=True, slots=True)
class Expected:
    """Of a square. mean : of visits' mean logarithms, known to this variance.  within : variance of a visit about it.
    scans : of the survey."""

    mean: float
    variance: float
    within: float
    scans: int


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """Logarithms of signal distances of c squares on f floors.

    floor : (c,) index into the map's floors.  square : (c, 2) column and row; the first begins at 0 m.
    scans : (c,) of the survey.  walks : (c,) those that were left out there, mean : (c,) of the means of these.
    floor_mean : (f,).  between, within : (f,) variance of squares about it, and of visits about their square.
    """

    floor: IntArray
    square: IntArray
    scans: IntArray
    walks: IntArray
    mean: FloatArray
    floor_mean: FloatArray
    between: FloatArray
    within: FloatArray

    def expected(self, floor: int, square: tuple[int, int]) -> Expected:
        """What visits of a square average to if nothing has changed. Squares of few walks are drawn to their floor's
        mean; one that nobody surveyed is expected to be as squares are."""
        here = np.flatnonzero((self.floor == floor) & (self.square == square).all(axis=1))
        scans, walks, own = 0, 0, 0.0
        if len(here):
            scans, walks, own = int(self.scans[here[0]]), int(self.walks[here[0]]), float(self.mean[here[0]])
        prior, each = 1.0 / float(self.between[floor]), walks / float(self.within[floor])
        mean = (prior * float(self.floor_mean[floor]) + each * own) / (prior + each)
        return Expected(mean, 1.0 / (prior + each), float(self.within[floor]), scans)


def square_of(x_m: float, y_m: float) -> tuple[int, int]:
    """The square that a place is in."""
    return int(x_m // CELL_M), int(y_m // CELL_M)


def log_distance(signal_distance: FloatArray) -> FloatArray:
    """Logarithm of signal distances."""
    return np.asarray(np.log(np.maximum(signal_distance, LEAST_DISTANCE)))


def likeness_of(fingerprints: Sequence[Fingerprint], left_out: LeftOutScans, floors: Sequence[str]) -> Likeness:
    """Learn from a survey. floors : those of its map, in order."""
    floor = np.array([floors.index(one.floor) for one in fingerprints], np.int64)
    square = np.array([square_of(one.x_m, one.y_m) for one in fingerprints], np.int64).reshape(-1, 2)
    cell, of_scan, scans = np.unique(np.column_stack([floor, square]), axis=0, return_inverse=True, return_counts=True)
    near = np.flatnonzero(left_out.nearest_m <= REACH_M)
    placed_in = of_scan.reshape(-1)[left_out.scan[near]]
    visit, of_visit = np.unique(np.column_stack([placed_in, left_out.walk[near]]), axis=0, return_inverse=True)
    logarithm = log_distance(left_out.signal_distance[near])
    visit_mean, at = _means(of_visit.reshape(-1), logarithm, len(visit)), visit[:, 0]
    mean, walks = _means(at, visit_mean, len(cell)), np.bincount(at, minlength=len(cell)).astype(np.int64)
    square_sum = np.bincount(at, (visit_mean - mean[at]) ** 2, len(cell)).astype(np.float64)
    known = [np.flatnonzero((cell[:, 0] == number) & (walks > 0)) for number in range(len(floors))]
    spread = np.array([_spread(mean[here], walks[here], square_sum[here]) for here in known]).reshape(-1, 3)
    return Likeness(cell[:, 0], cell[:, 1:], scans, walks, mean, *spread.T)


def likeness_sections(found: Likeness) -> dict[str, FloatArray]:
    """What is stored with a radio map."""
    cells = np.column_stack([found.floor, found.square, found.scans, found.walks, found.mean]).astype(np.float64)
    return {CELLS: cells, FLOORS: np.column_stack([found.floor_mean, found.between, found.within])}


def stored_likeness(sections: Mapping[str, NDArray[Any]]) -> Likeness | None:
    """What a radio map carries; None of one that was built before maps did."""
    cells, floors = sections.get(CELLS), sections.get(FLOORS)
    if cells is None or floors is None:
        return None
    cells, floors = cells.reshape(-1, 6), floors.reshape(-1, 3)  # of a survey of beacons alone, lists without rows
    numbers = cells[:, :5].astype(np.int64)
    return Likeness(numbers[:, 0], numbers[:, 1:3], numbers[:, 3], numbers[:, 4], cells[:, 5], *floors.T)


def _spread(mean: FloatArray, walks: IntArray, square_sum: FloatArray) -> tuple[float, float, float]:
    """Mean over squares, variance between them and within them: one-way analysis of variance by moments."""
    repeats = int(walks.sum()) - len(walks)
    within = float(square_sum.sum()) / repeats if repeats >= LEAST_REPEATS else USUAL_WITHIN
    within = max(within, LEAST_WITHIN)
    if len(mean) < LEAST_REPEATS:
        return float(mean.mean()) if len(mean) else USUAL_MEAN, USUAL_BETWEEN, within
    between = float(np.var(mean, ddof=1)) - within * float(np.mean(1.0 / walks))
    return float(mean.mean()), max(between, 0.1 * within), within


def _means(group: IntArray, value: FloatArray, count: int) -> FloatArray:
    total, each = np.bincount(group, value, minlength=count), np.bincount(group, minlength=count)
    return np.asarray(total / np.maximum(each, 1), np.float64)
