"""Weibull-Bayes: the posterior over reference points from the likelihood of each reading.

That of method A (docs/methods/integrity_ukf.md has the paper).
The likelihood depends on how far a reading lies from the point's mean and on the point's standard deviation alone, so
one small table holds all of them and no distribution function is called for a scan.

Missing access points: what the scan heard and a point never did counts as the least likelihood there; what a point
hears and the scan did not costs `unheard` of that; what the map does not know is left out.
Differs from the paper, where the settings are not PAPER: readings weigh by their strength, since weak ones come and go;
a point's unheard access points cost something, else points that hear everything win; and the sum of logs counts as
that of a few `witnesses`, since access points of one room fade together. In any case the table rounds the distance to
STEP_DB. docs/decisions/0003-matching.md has what each is worth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numba
import numpy as np

from app.estimation.arrays import Float32Array, FloatArray, IntArray, position_of
from app.wifi.match import Match, known_access_points, matched_nearest
from app.wifi.match_index import index_of
from app.wifi.radio_map import Int32Array, RadioMap
from app.wifi.representation import represent
from app.wifi.weibull import SCALE_RANGE_DB, weibull_of, window_likelihood

STEP_DB = 0.1
_REACH_DB = 40.0
"""Beyond this from the mean every likelihood is at its floor."""
_STD_STEP_DB = 0.05
_STD_BINS = round(SCALE_RANGE_DB[1] / _STD_STEP_DB) + 1


@dataclass(frozen=True, slots=True)
class WeibullSettings:
    """How likelihoods become a posterior.

    least_likelihood : keeps one unlucky access point from vetoing a point.  by_strength : readings weigh by their powed
    value, else all the same.  unheard : share of the least likelihood that an access point costs which the point hears
    and the scan does not.  witnesses : how many independent access points a scan counts as; None for as many as it
    holds.  neighbours : best points of the posterior mean.
    """

    least_likelihood: float = 1e-3
    by_strength: bool = True
    unheard: float = 0.5
    witnesses: float | None = 4.0
    neighbours: int = 8


PAPER = WeibullSettings(by_strength=False, unheard=0.0, witnesses=None)


@dataclass(frozen=True, slots=True, eq=False)
class _Bins:
    """(n,) of each pair: 10 x mean_dbm, and the row of the table."""

    mean: Int32Array
    std: Int32Array


_held: WeakKeyDictionary[RadioMap, _Bins] = WeakKeyDictionary()
_tables: dict[float, Float32Array] = {}


def weibull_bayes(
    radio_map: RadioMap,
    bssid: IntArray,
    rssi_dbm: FloatArray,
    settings: WeibullSettings = WeibullSettings(),
    floor: int | None = None,
    points: IntArray | None = None,
) -> Match | None:
    """Match one scan: posterior mean of the most likely points, prior uniform. Arguments as of app.wifi.wknn.wknn.

    The `distance` of a neighbour is its mean negative log likelihood per access point.
    """
    index = index_of(radio_map)
    known = known_access_points(index, bssid)
    if known == 0:
        return None
    unlikeliness = -mean_log_likelihoods(radio_map, bssid, rssi_dbm, settings)
    witnesses = known if settings.witnesses is None else settings.witnesses

    def posterior(unlikeliness: FloatArray) -> FloatArray:
        return np.asarray(np.exp(witnesses * (unlikeliness[0] - unlikeliness)), np.float64)

    among = unlikeliness if points is None else unlikeliness[points]
    return matched_nearest(index, among, points, floor, settings.neighbours, posterior, known)


def mean_log_likelihoods(
    radio_map: RadioMap, bssid: IntArray, rssi_dbm: FloatArray, settings: WeibullSettings = PAPER
) -> FloatArray:
    """(p,) log likelihood of a scan at every reference point, per access point that scan and map have in common."""
    index = index_of(radio_map)
    bins = _bins(radio_map)
    strength = represent(rssi_dbm, index.representation).astype(np.float64)
    return _sum_logs(
        index.bssid,
        index.start,
        index.point,
        bins.mean,
        bins.std,
        index.value,
        index.total,
        bssid,
        np.rint(np.asarray(rssi_dbm) / STEP_DB).astype(np.int64),
        strength if settings.by_strength else np.ones_like(strength),
        _table(settings.least_likelihood),
        math.log(settings.least_likelihood),
        settings.unheard,
    )


def _bins(radio_map: RadioMap) -> _Bins:
    bins = _held.get(radio_map)
    if bins is None:
        widest_db = SCALE_RANGE_DB[1]
        std_db = np.minimum(np.sqrt(radio_map.variance_db2, dtype=np.float64), widest_db)
        std_db[radio_map.count == 1] = widest_db  # a single reading shows no spread
        bins = _held[radio_map] = _Bins(
            np.rint(radio_map.mean_dbm / STEP_DB).astype(np.int32), np.rint(std_db / _STD_STEP_DB).astype(np.int32)
        )
    return bins


def _table(least_likelihood: float) -> Float32Array:
    """(standard deviations, distances from the mean) log of the likelihood, at least the log of its floor."""
    table = _tables.get(least_likelihood)
    if table is None:
        std_db = np.arange(_STD_BINS)[:, np.newaxis] * _STD_STEP_DB
        above_db = np.arange(-round(_REACH_DB / STEP_DB), round(_REACH_DB / STEP_DB) + 1) * STEP_DB
        weibull = weibull_of(np.zeros_like(std_db), std_db)
        likelihood = window_likelihood(above_db, weibull.k, weibull.lambda_db, weibull.theta_dbm)
        table = _tables[least_likelihood] = np.log(np.maximum(likelihood, least_likelihood)).astype(np.float32)
    return table


@numba.njit(cache=True, nogil=True)
def _sum_logs(
    known: IntArray,
    start: IntArray,
    point: Int32Array,
    mean: Int32Array,
    std: Int32Array,
    value: Float32Array,
    total: FloatArray,
    bssid: IntArray,
    reading: IntArray,
    weight: FloatArray,
    table: Float32Array,
    least: float,
    unheard: float,
) -> FloatArray:
    above_least = np.zeros(len(total))
    shared = np.zeros(len(total))
    whole = 0.0
    middle = table.shape[1] // 2
    for k in range(len(bssid)):
        i = position_of(bssid[k], known)
        if i < 0:
            continue
        whole += weight[k]
        for j in range(start[i], start[i + 1]):
            p = point[j]
            shared[p] += value[j]
            at = reading[k] - mean[j] + middle
            if 0 <= at < table.shape[1]:
                above_least[p] += weight[k] * (table[std[j], at] - least)
    if whole == 0.0:
        return np.full(len(total), -np.inf)
    for p in range(len(total)):
        above_least[p] = least + (above_least[p] + unheard * least * (total[p] - shared[p])) / whole
    return above_least
